"""The values that travel through the cell: Utterance, Request, Assembly, BuildPlan and their parts.

Everything here is frozen and does no I/O. A value goes one way, from the spoken sentence to the
outcome of the last placement; no stage reaches back. All of them serialise to JSON through
pydantic, so that the bus, the journal, the report and files on disk share one form.

Cells are ``[x, y, z]`` with z up, layer 0 on the floor and the origin at the workspace's minimum
corner, everywhere: plans, journal, world and reports.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal, NamedTuple, get_args

from pydantic import BaseModel, ConfigDict, Field


class Value(BaseModel):
    """Base of every value: frozen, and with no room for a misspelt field."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Cell(NamedTuple):
    """Index of one voxel-sized cell of the workspace grid; z is up and layer 0 is on the floor."""

    x: int
    y: int
    z: int

    def below(self) -> Cell:
        """The cell under this one (its z may be -1, which is the floor)."""
        return Cell(self.x, self.y, self.z - 1)

    def neighbours(self) -> tuple[Cell, ...]:
        """The six cells that share a face with this one."""
        x, y, z = self
        return (
            Cell(x - 1, y, z),
            Cell(x + 1, y, z),
            Cell(x, y - 1, z),
            Cell(x, y + 1, z),
            Cell(x, y, z - 1),
            Cell(x, y, z + 1),
        )


class Utterance(Value):
    """What was heard, before anyone judged what it means."""

    text: str
    source: Literal["microphone", "wav", "text"]
    recogniser: str = "none"
    """Which back end turned sound into words; ``none`` for typed text."""
    confidence: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    audio_s: Annotated[float, Field(ge=0.0)] = 0.0
    """Length of the audio heard, in seconds."""


class Intent(StrEnum):
    """What a sentence asks for."""

    DESIGN = "design"
    EDIT = "edit"
    CONTROL = "control"
    QUERY = "query"
    NONE = "none"


Axis = Literal["width", "depth", "height"]
Attribute = int | str | bool


class Correction(Value):
    """Words that were taken for others, because they sound like them."""

    heard: str
    taken: str


EditOp = Literal["scale", "add", "remove", "set", "replace", "turn", "undo"]
EDIT_OPS: tuple[EditOp, ...] = get_args(EditOp)


class Edit(Value):
    """One change to the object that was designed before.

    ``scale`` changes a size and ``set`` fixes one, or an attribute; ``add`` and ``remove`` are
    about parts; ``replace`` wants another object, which the request names; ``turn`` turns it about
    the vertical, and ``undo`` takes the last change back.
    """

    op: EditOp
    part: str = ""
    """What it is about, as it was said, singular (``leg``, ``shelf``); empty for all of it."""
    attribute: str = ""
    """What designs call that: ``legs``, ``tiers``, ``back``, ``colour``, ``count``, ``strength``,
    ``roundness``, ``simplicity``, ``weight``, ``looks``; empty for a size."""
    axis: Literal["width", "depth", "height", "length"] | None = None
    """Of a size; ``length`` is the longer side, or a part's own. None is every axis alike."""
    direction: Literal["+", "-"] | None = None
    """Of ``scale``: more or less of it."""
    amount: Annotated[float, Field(gt=0.0)] | None = None
    """How much, or how many parts. None: nobody said, which is one voxel or one part, and for
    ``remove`` every part of that name."""
    unit: Literal["parts", "voxels", "metres", "times", "degrees"] | None = None
    """Of ``amount``; ``times`` is a factor: twice as tall is ``+`` 2 times. ``degrees`` are
    anticlockwise, seen from above."""
    value: Attribute | None = None
    """Of ``set``: what an attribute becomes."""


class Request(Value):
    """What the cell understood: the object to design, or why there is none."""

    text: str
    """The sentence as it came, before anything was corrected."""
    intent: Intent
    phrase: str
    """The phrase that names the object, lower case, without its article; ``false`` for none."""
    objects: tuple[str, ...] = ()
    """Head nouns of what is to be built, singular."""
    kind: str = ""
    """What kind of thing the first of them is, such as ``animal``, ``person``, ``plant``,
    ``artifact`` or, of a story, ``character``; empty where that is not known."""
    count: Annotated[int, Field(ge=0)] = 0
    attributes: dict[str, Attribute] = Field(default_factory=dict)
    """Such as ``legs``, ``tiers``, ``back``, ``arms``, ``glyph``."""
    features: tuple[str, ...] = ()
    """What else it should have, of which no attribute speaks, as it was said: ``floppy ears``."""
    dimensions_m: dict[Axis, float] = Field(default_factory=dict)
    """Only sizes that the speaker stated, in metres."""
    dimension_sources: dict[Axis, Literal["stated", "voxels", "axis_assumed"]] = Field(
        default_factory=dict
    )
    """Where each size comes from: said with its unit, counted in voxels ("ten blocks high"), or
    said without saying which way, and taken for the height."""
    edits: tuple[Edit, ...] = ()
    """For ``edit``: the changes, in the order in which they were said."""
    hints: tuple[Literal["too_small", "too_big", "too_many"], ...] = ()
    """What is known of it before it is designed: smaller than a voxel, larger than the workspace,
    or more than one object or all the parts make."""
    command: str | None = None
    """For ``control``: one of the operator's or visitor's commands, such as ``stop``."""
    ask: str = ""
    """What should be asked back, in words for the visitor; empty where nothing is unclear."""
    refusal: str = ""
    """Why it shall not be built although it could be, in words for the visitor; empty where it may
    be."""
    corrections: tuple[Correction, ...] = ()
    """What was taken for something else than was heard."""
    reason: str = ""
    """What was decided, in words for the visitor."""
    confidence: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    """How sure the back end is of its decision; no probability."""
    back_end: str = "rules"
    """Which back end decided."""
    why: str = ""
    """By what it decided, in words for whoever looks into it."""
    cloud: str = ""
    """Where the words were sent to be understood; empty when they never left this computer."""

    @property
    def buildable(self) -> bool:
        """Whether it is a wish for an object that may be built."""
        return self.intent is Intent.DESIGN and not self.refusal

    def with_nothing_to_change(self) -> Request:
        """The same where nothing was designed before: "make it a bench" is a wish for one."""
        if self.intent is not Intent.EDIT or [edit.op for edit in self.edits] != ["replace"]:
            return self
        return self.model_copy(update={"intent": Intent.DESIGN, "edits": (), "reason": ""})


class Check(Value):
    """One question asked of an assembly, and its answer."""

    name: str
    passed: bool
    message: str
    cells: tuple[Cell, ...] = ()
    """The cells that made it fail; empty where it passed."""


class Change(Value):
    """One change made to what was asked for, in words that a visitor understands."""

    what: str
    why: str


class Assembly(Value):
    """A set of occupied cells at one voxel pitch."""

    cells: tuple[Cell, ...]
    """Sorted by z, then x, then y; no duplicates."""
    pitch_m: Annotated[float, Field(gt=0.0)]

    @classmethod
    def of(cls, cells: object, pitch_m: float) -> Assembly:
        """Build from any iterable of 3-sequences of int; sorts and drops duplicates."""
        unique = {Cell(int(c[0]), int(c[1]), int(c[2])) for c in cells}  # type: ignore[attr-defined]
        return cls(cells=tuple(sorted(unique, key=lambda c: (c.z, c.x, c.y))), pitch_m=pitch_m)

    @property
    def size(self) -> tuple[int, int, int]:
        """Extent in cells along x, y and z, of the bounding box; (0, 0, 0) when empty."""
        if not self.cells:
            return (0, 0, 0)
        spans = [(min(a), max(a)) for a in zip(*self.cells, strict=True)]
        return (
            spans[0][1] - spans[0][0] + 1,
            spans[1][1] - spans[1][0] + 1,
            spans[2][1] - spans[2][0] + 1,
        )


class StepKind(StrEnum):
    """What a plan step does with its part."""

    PLACE = "place"
    REMOVE = "remove"


class Pace(Value):
    """How fast a movement is told to be."""

    speed_m_s: Annotated[float, Field(gt=0.0, le=3.0)]
    """Greatest speed of the TCP."""
    acceleration_m_s2: Annotated[float, Field(gt=0.0, le=20.0)]
    """Its acceleration."""

    def __str__(self) -> str:
        return f"{self.speed_m_s:g} m/s and {self.acceleration_m_s2:g} m/s2"


class TakeOff(Value):
    """How a placed part is parted from its neighbours, by the gentlest way that the rest bears."""

    how: Literal["pull", "peel", "twist"]
    """``pull``: straight up; ``peel``: tilted first; ``twist``: turned about the vertical first."""
    direction: tuple[int, int] | None = None
    """Of a peel: where the part's top goes, along x, y or a diagonal."""
    hinge_m: tuple[float, float] | None = None
    """Of a peel: the level axis that it turns about, from the part's centre: how far on the side to
    which its top goes, and how far up."""
    force_n: Annotated[float, Field(ge=0.0)]
    """What the arm applies at most: upward; of a peel or twist, its couple divided by the part's
    edge."""


class Step(Value):
    """One part put to, or taken from, one cell."""

    index: Annotated[int, Field(ge=0)]
    kind: StepKind
    cell: Cell
    clearance_m: float | None = None
    """Height of the TCP above the floor at which the part may cross at this step."""
    duration_s: float | None = None
    """Predicted cell time of this step with the latch: both movements, from where the part before
    was put (or home) by way of the pick station to this cell, and what the arm stands meanwhile."""
    margin: float | None = None
    """How many times stronger the magnets are than this step needs, while its part is pressed in or
    comes off and with the structure after it. None where it needs none; at least 1 holds."""
    take_off: TakeOff | None = None
    """Of a removal: how the part comes off; None of a placement."""


class PartOutcome(Value):
    """One step of a job, after its part was placed, or taken off and brought away."""

    step: int
    kind: StepKind = StepKind.PLACE
    cell: Cell
    seconds: float
    """Cell time from the end of the part before to the end of this one."""
    waited_s: float
    """Share of it in which the arm waited for the belt."""
    latch_s: float = 0.0
    """Share of it in which the arm stood while the latch moved."""
    route_s: float = 0.0
    """Share of it in which the arm stood because its way was not planned yet."""
    touch_s: float = 0.0
    """Share of it in which the arm felt for the part's seat, and whether the gripper was free."""
    predicted_s: float | None = None
    """What was told for it before."""
    retries: int = 0


class Weakest(Value):
    """The joint that comes nearest to giving way while a plan is carried out."""

    step: Annotated[int, Field(ge=0)]
    """Index of the step at which it does."""
    margin: float
    """How many times stronger the magnets are than this step needs."""
    cell: Cell
    """One of the two parts that it joins."""
    other: Cell
    """The other part, or with z -1 the floor below it."""
    description: str
    """Where it is, in words: ``between [2, 0, 1] and [1, 0, 1]``."""


class Closeness(Value):
    """How much of the shape that was asked for a plan keeps."""

    score: Annotated[float, Field(ge=0.0, le=1.0)]
    """Of the planned object; 1 is exactly what was asked for."""
    baseline_score: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    """Of what the paper's rescaling makes of the same shape; none where it makes nothing, or keeps
    more but breaks a rule or was not found to stand."""
    bound: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    """No object has a higher score than this, of those that have the symmetry of the shape, no gaps
    that it has not, no rows that reach out too far to be sought, and no edge that is longer than
    its; none where that was not found out."""
    proven: bool = False
    """Whether none of those objects has a higher score than the planned one."""


class BuildPlan(Value):
    """What the arm will do, step by step, and what was checked and changed to get there."""

    plan_id: str
    """Hash of the steps and the cell's geometry: the same object in the same cell has the same."""
    title: str
    pitch_m: float
    assembly: Assembly
    steps: tuple[Step, ...]
    checks: tuple[Check, ...]
    changes: tuple[Change, ...] = ()
    questions: tuple[str, ...] = ()
    """What must be asked before building, such as a wished-for size that cannot fit."""
    policy: str = "cellctl"
    provenance: str = ""
    """Where the shape came from: the generator and its description."""
    weakest: Weakest | None = None
    """Where it comes nearest to giving way; none where no step asks anything of a joint."""
    closeness: Closeness | None = None
    """How near it is to what was asked for; none where nothing had to be sought."""
    wanted: tuple[Cell, ...] = ()
    """Cells of the shape as it was asked for, where they lie over the assembly best; empty where
    none was changed. Some may be outside the workspace."""

    @property
    def parts(self) -> int:
        """How many parts the plan places."""
        return sum(1 for step in self.steps if step.kind is StepKind.PLACE)


class Role(StrEnum):
    """Who asks: a visitor may ask for and stop things, an operator may do everything."""

    VISITOR = "visitor"
    OPERATOR = "operator"
