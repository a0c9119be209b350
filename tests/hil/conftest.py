"""The cell under test, and the operator beside it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from cellctl.assembly import Role
from cellctl.client import CellClient, NoDaemonError
from cellctl.config import CellConfig, load_config

CONFIG = "CELLCTL_HIL_CONFIG"
collect_ignore_glob = [] if os.environ.get(CONFIG) else ["test_*.py"]


@pytest.fixture(scope="session")
def config() -> CellConfig:
    """The configuration of the cell, whose devices no daemon holds."""
    config = load_config(Path(os.environ[CONFIG]))
    try:
        with CellClient.for_role(config, Role.OPERATOR, timeout_s=1.0) as cell:
            cell.snapshot()
    except NoDaemonError:
        return config
    pytest.exit("A daemon runs this cell and holds its devices. Stop it first.")


class Operator:
    """Who stands beside the cell."""

    def allows(self, what: str, look: str) -> None:
        """Ask before something moves; skips the test unless the answer is yes.

        Args:
            what: will happen.
            look: must be so before it may.
        """
        if self._answer(f"\n{what}\n  {look}\n  Go on? [yes/no] ") != "yes":
            pytest.skip("the operator did not say yes")

    def does(self, what: str) -> None:
        """Have the operator do something, and wait until it is done."""
        if self._answer(f"\n{what}\n  Done? [yes/no] ") != "yes":
            pytest.skip("the operator did not do it")

    @staticmethod
    def _answer(question: str) -> str:
        sys.stdout.write(question)
        sys.stdout.flush()
        return sys.stdin.readline().strip().lower()


@pytest.fixture(scope="session")
def operator() -> Operator:
    """The operator at the terminal."""
    return Operator()
