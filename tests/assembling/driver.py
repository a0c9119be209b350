"""A daemon in small, to be killed: ``python -m tests.assembling.driver CONFIG_JSON``.

Connects an arm, prints the process id of its arm process, and starts along a fixed path at the
first line of input.
"""

from __future__ import annotations

import asyncio
import sys

from cellctl.assembling.arm_process import RemoteArm
from cellctl.config import CellConfig
from tests.assembling.paths import away_from


async def _drive(config: CellConfig) -> None:
    arm = RemoteArm(config)
    await arm.connect()
    state = arm.state()
    assert state is not None
    sys.stdout.write(f"{arm.process_id}\n")
    sys.stdout.flush()
    await asyncio.get_running_loop().run_in_executor(None, sys.stdin.readline)
    await arm.follow(away_from(state.tcp_pose), 3.0)


if __name__ == "__main__":
    asyncio.run(_drive(CellConfig.model_validate_json(sys.argv[1])))
