"""What visitors want to be called."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import Final

_MOST: Final = 100
_ANOTHER_IN_FRONT_S: Final = 60.0
"""After so long without a word from there somebody else may stand before the cell (cell time)."""


class Names:
    """Names by the marks of their visitors.

    Whoever stands before the cell has no mark: that name goes with the one who said it.

    Args:
        now_s: cell time.
    """

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self._names: OrderedDict[str, str] = OrderedDict()
        self._front_heard_s = now_s()

    def heard(self, owner: str, *, at_work: bool) -> None:
        """Somebody says something.

        Args:
            owner: mark of that visitor; empty for the one in front of the cell.
            at_work: whether a job of that visitor is under way.
        """
        if owner:
            return
        now_s = self._now_s()
        if now_s - self._front_heard_s > _ANOTHER_IN_FRONT_S and not at_work:
            self._names.pop("", None)
        self._front_heard_s = now_s

    def of(self, owner: str) -> str:
        """What that visitor is called; empty where it is not known."""
        return self._names.get(owner, "")

    def keep(self, owner: str, name: str) -> None:
        """That visitor wants to be called so; the name longest unused is forgotten for it."""
        self._names[owner] = name
        self._names.move_to_end(owner)
        if len(self._names) > _MOST:
            self._names.popitem(last=False)
