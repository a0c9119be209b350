"""The paper's figures as it prints them, each with its table or section, and where they disagree.

Names of objects are those of ``objects``. Nothing here is computed.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from cellctl.config import LimitsSection

LIMITS: Final = LimitsSection(inventory_parts=40, overhang_cells=3, stack_cells=4)
"""Sections 3.3.1 and 3.3.2."""

GRID: Final = (6, 5, 6)
"""Section 4.2: 60 cm x 50 cm x 60 cm at 10 cm."""

PITCH_M: Final = 0.10
"""Section 3.2: a component is 10 cm x 10 cm x 10 cm."""

CELL_CM3: Final = 1000.0
"""Of one such component."""


class Rescaling(NamedTuple):
    """A row of tables 2 to 4."""

    baseline_parts: int
    check: str
    rescaled_parts: int


COUNT: Final = {
    "stool": Rescaling(45, "fail", 30),
    "shelf": Rescaling(60, "fail", 32),
    "letter_t": Rescaling(8, "pass", 8),
    "table": Rescaling(21, "pass", 21),
}
"""Table 2."""

OVERHANG: Final = {
    "stool": Rescaling(45, "pass", 45),
    "shelf": Rescaling(60, "fail", 54),
    "letter_t": Rescaling(8, "pass", 8),
    "table": Rescaling(21, "pass", 21),
}
"""Table 3."""

STACK: Final = {
    "stool": Rescaling(46, "pass", 46),
    "shelf": Rescaling(60, "pass", 60),
    "letter_t": Rescaling(8, "fail", 7),
    "table": Rescaling(21, "fail", 20),
}
"""Table 4."""

ABLATION: Final = {
    "stool": ("fail", "pass", "pass", "fail", "pass"),
    "shelf": ("fail", "fail", "pass", "fail", "pass"),
    "letter_t": ("pass", "pass", "fail", "pass", "pass"),
    "table": ("pass", "pass", "pass", "fail", "pass"),
}
"""Table 1: without count, overhang, stack, connectivity; and the complete pipeline."""

NAIVE_TEXT: Final = {"stool": "fail", "shelf": "pass", "letter_t": "fail", "table": "fail"}
"""Section 4.2.4: whether the object is completed when its parts are merely sorted."""

CONNECTED_TEXT: Final = "pass"
"""Section 4.2.4: *when connectivity-based sequencing is enabled, all ... are completed*."""

VOLUME_CM3: Final = {"stool": 6496, "shelf": 11831, "letter_t": 4279, "table": 7356}
"""Table 6."""

TIME_S: Final = {"stool": 216, "shelf": 312, "letter_t": 65, "table": 221}
"""Table 6: 3m36s, 5m12s, 1m05s, 3m41s."""

FDM_H: Final = 73.75
"""Section 4.3: 3 days 1 hour 45 minutes for the stool, on a large FDM printer, simulated."""

SPEED: Final = 2.0
"""Section 4.2.5: the speed that was used; printed in mm/s."""

ACCELERATION: Final = 1.0
"""Section 4.2.5: the acceleration that was used; printed in mm/s2."""

REQUESTS: Final = (
    ("make me a coffee table", "coffee table"),
    ("I want a simple stool", "simple stool"),
    ("I need a shelf", "shelf"),
    ("Knowledge", "false"),
    ("create beauty", "false"),
    ("I need something to hold memories", "false"),
    ("I need a box to hold memories", "box"),
)
"""Sections 3.1 and 4.1: what is said, and the phrase that the language model returned."""

_STOOL_45 = "Tables 2 and 3 and section 4.2.1 count 45 parts for the same stool."
_T_NAIVE = "Section 4.2.4: sorted by z, x, y, the letter T has disconnected parts."
_SHELF_NAIVE = "Section 4.2.4: only the shelf succeeds under naive sorting."
_SPEED_UNIT = (
    "In mm/s the parts of table 6 would take hours. Read in m/s, the path of algorithm 5 comes "
    "to minutes: see the table time."
)

CONTRADICTED: Final = {
    ("stack", "stool", "baseline"): _STOOL_45,
    ("stack", "stool", "rescaled"): _STOOL_45,
    ("ablation", "table", "stack"): "Table 4: the table fails the vertical stack check.",
    ("ablation", "letter_t", "connectivity"): _T_NAIVE,
    ("ablation", "shelf", "connectivity"): _SHELF_NAIVE,
    ("order", "letter_t", "table 1"): _T_NAIVE,
    ("order", "letter_t", "text"): "Table 1: it passes without connectivity search.",
    ("order", "shelf", "table 1"): _SHELF_NAIVE,
    ("order", "shelf", "text"): "Table 1: it fails without connectivity search, "
    "and section 4.2 says so too.",
    ("volume", "shelf", "volume"): "Section 4.3: the volumes range from 4279 to 7356 cm³.",
    ("time", "shelf", "time"): "Abstract: within 5 minutes; section 4.3: in 1 to 5 minutes.",
    **{("speed", name, "time"): _SPEED_UNIT for name in TIME_S},
}
"""(table, object, figure) -> what else the paper says of it."""
