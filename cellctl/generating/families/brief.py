"""What a family of designs is told, and what it gives back."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from cellctl.assembly import Request
from cellctl.errors import DesignError
from cellctl.generating.boxes import Box

Attribute = int | str | bool

_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def counted(number: int, noun: str) -> str:
    """``one leg``, ``two legs``, ``12 legs``."""
    word = _NUMBERS[number] if 0 <= number < len(_NUMBERS) else str(number)
    return f"{word} {noun}" if number == 1 else f"{word} {noun}s"


def titled(noun: str, *features: str) -> str:
    """``chair with arms and no back``; empty features are skipped."""
    said = [feature for feature in features if feature]
    return f"{noun} with {' and '.join(said)}" if said else noun


@dataclass
class Brief:
    """One wish, measured in cells. It records which attributes a family has honoured."""

    noun: str
    attributes: dict[str, Attribute]
    stated_cells: dict[str, int]
    """Stated sizes in whole cells, by ``width``, ``depth``, ``height``; not yet limited."""
    grid: tuple[int, int, int]
    used: set[str] = field(default_factory=set)

    @classmethod
    def of(
        cls, noun: str, request: Request, pitch_m: float, workspace_m: tuple[float, float, float]
    ) -> Brief:
        """Measure a request in cells of one pitch."""
        nx, ny, nz = (int(edge / pitch_m + 1e-9) for edge in workspace_m)
        stated: dict[str, int] = {
            name: max(1, math.floor(size_m / pitch_m + 0.5))
            for name, size_m in request.dimensions_m.items()
        }
        return cls(noun, dict(request.attributes), stated, (nx, ny, nz))

    @property
    def unused(self) -> list[str]:
        """Attributes that were asked for and that nothing has honoured."""
        return sorted(
            name
            for name, value in self.attributes.items()
            if name not in self.used and value is not False
        )

    def whole(self, name: str, default: int, least: int, most: int) -> int:
        """A counted attribute, such as ``legs``.

        Raises:
            DesignError: a number that this family cannot have.
        """
        self.used.add(name)
        value = self.attributes.get(name)
        if isinstance(value, bool) or not isinstance(value, int):
            return default
        if not least <= value <= most:
            part = name.removesuffix("s")
            limit = f"at least {counted(least, part)}" if value < least else f"at most {most}"
            raise DesignError(
                f"I cannot design a {self.noun} with {counted(value, part)}; {limit} here."
            )
        return value

    def flag(self, name: str, default: bool) -> bool:
        """An attribute that is there or not, such as ``back``."""
        self.used.add(name)
        return bool(self.attributes.get(name, default))

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


@dataclass(frozen=True)
class Design:
    """A finished description: boxes in cells, z up, and what it is called."""

    title: str
    boxes: tuple[Box, ...]


@dataclass(frozen=True)
class Family:
    """One kind of object."""

    name: str
    nouns: tuple[str, ...]
    """Every singular noun that means it; the first is the family's own."""
    build: Callable[[Brief], Design]
