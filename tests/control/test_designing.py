"""What the designer process loads before it is asked for anything."""

from __future__ import annotations

import subprocess
import sys


def test_the_solver_is_loaded_before_any_plan_has_its_budget() -> None:
    code = (
        "import sys\n"
        "from cellctl.control.designing import warm_up\n"
        "assert not any(name.startswith('ortools') for name in sys.modules)\n"
        "warm_up()\n"
        "assert 'ortools.sat.python.cp_model' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
