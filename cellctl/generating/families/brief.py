"""What a family of designs is told, and what it gives back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from cellctl.assembly import Attribute
from cellctl.description import FamilyDescription
from cellctl.errors import DesignError
from cellctl.generating.boxes import Box

_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def counted(number: int, noun: str) -> str:
    """``one leg``, ``two legs``, ``12 legs``."""
    word = _NUMBERS[number] if 0 <= number < len(_NUMBERS) else str(number)
    if number == 1:
        return f"{word} {noun}"
    return f"{word} {noun}es" if noun.endswith(("ch", "x", "s")) else f"{word} {noun}s"


def titled(noun: str, *features: str) -> str:
    """``chair with arms and no back``; empty features are skipped."""
    said = [feature for feature in features if feature]
    return f"{noun} with {' and '.join(said)}" if said else noun


@dataclass(frozen=True)
class Count:
    """An attribute that is counted in the finished object."""

    least: int
    most: int
    meaning: str


@dataclass(frozen=True)
class Flag:
    """An attribute that is there or not."""

    meaning: str


@dataclass(frozen=True)
class Sign:
    """An attribute that is one letter, digit or mark."""

    meaning: str


Takes = Mapping[str, Count | Flag | Sign]


@dataclass
class Brief:
    """One description, measured in cells. It records the attributes that a family decided on."""

    noun: str
    attributes: dict[str, Attribute]
    stated_cells: dict[str, int]
    """Stated sizes in whole cells, by ``width``, ``depth``, ``height``; not yet limited."""
    grid: tuple[int, int, int]
    takes: Takes
    values: dict[str, Attribute] = field(default_factory=dict)
    """What each attribute came to be, stated or by default."""

    @classmethod
    def of(
        cls, description: FamilyDescription, family: Family, pitch_m: float, grid: tuple[int, ...]
    ) -> Brief:
        """Measure a description in cells of one pitch."""
        nx, ny, nz = grid
        stated: dict[str, int] = {
            name: max(1, math.floor(size_m / pitch_m + 0.5))
            for name, size_m in description.size_m.items()
        }
        noun = description.noun or family.name
        return cls(noun, dict(description.attributes), stated, (nx, ny, nz), family.takes)

    def count(self, name: str, default: int) -> int:
        """A counted attribute, such as ``legs``.

        Raises:
            DesignError: a number that this family cannot have.
        """
        known = self.takes[name]
        assert isinstance(known, Count), name
        value = self.attributes.get(name)
        if value is None or isinstance(value, bool) or not isinstance(value, int):
            value = default
        elif value != default and not known.least <= value <= known.most:
            part = name.removesuffix("es") if name == "arches" else name.removesuffix("s")
            limit = (
                f"at least {counted(known.least, part)}"
                if value < known.least
                else f"at most {known.most}"
            )
            raise DesignError(
                f"I cannot design a {self.noun} with {counted(value, part)}; {limit} here."
            )
        self.values[name] = value
        return value

    def flag(self, name: str, default: bool) -> bool:
        """An attribute that is there or not, such as ``back``."""
        value = bool(self.attributes.get(name, default))
        self.values[name] = value
        return value

    def size(
        self, width: int, depth: int, height: int, least: tuple[int, int, int] = (1, 1, 1)
    ) -> tuple[int, int, int]:
        """Width, depth and height in cells: as stated, else the default; always within the grid.

        A stated size beyond ``least`` or the grid is limited here. The plan compares the outcome
        with what was said, and asks.
        """
        wanted = (
            self.stated_cells.get("width", width),
            self.stated_cells.get("depth", depth),
            self.stated_cells.get("height", height),
        )
        nx, ny, nz = self.grid
        return (
            max(least[0], min(wanted[0], nx)),
            max(least[1], min(wanted[1], ny)),
            max(least[2], min(wanted[2], nz)),
        )

    def refuse_short(self, what: str, height: int) -> DesignError:
        """That so much does not fit into a height that was asked for, to be raised."""
        return DesignError(
            f"I cannot fit {what} into a {self.noun} {height} parts high.",
            "Ask for fewer, or for more height.",
        )


@dataclass(frozen=True)
class Design:
    """A finished description: boxes in cells, z up, its front towards -y, and what it is called."""

    title: str
    boxes: tuple[Box, ...]


@dataclass(frozen=True)
class Family:
    """One kind of object."""

    name: str
    nouns: tuple[str, ...]
    """Every singular noun that means it; the first is the family's own."""
    build: Callable[[Brief], Design]
    takes: Takes = field(default_factory=dict)
    """The attributes it honours."""
