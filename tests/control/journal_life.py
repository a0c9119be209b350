"""A process that writes to a journal until it is killed; it says what is acknowledged.

``python -m tests.control.journal_life PATH``: one line for each act, when it has survived.
"""

from __future__ import annotations

import asyncio
import os
import sys
from pathlib import Path

from cellctl.control.acts import ActKind
from cellctl.feeding.inventory import Move
from tests.control.journals import CELLS, opened, record


async def live(path: Path) -> None:
    """Build and take apart for ever."""
    async with opened(path) as journal:
        for act in journal.unsettled():
            journal.settle(act.act_id, "interrupted")
        while True:
            standing = journal.ledger.standing
            cell = next((cell for cell in CELLS if cell not in standing), None)
            if journal.ledger.holding:
                act_id = await journal.intend(ActKind.RELEASE, "job", 0, cell)
                journal.settle(act_id, "done", moves=(Move.PLACE,))
            elif cell is None or journal.ledger.counts.belt == 0:
                moves = (Move.TAKE_APART,) * len(standing) + (Move.LAY,) * len(standing)
                await journal.record(ActKind.CLEAR, moves=moves)
            else:
                act_id = await journal.intend(ActKind.PICK, "job", 0, cell)
                journal.settle(act_id, "done", moves=(Move.PICK,))
            journal.keep_job(record())
            os.write(1, f"{journal.recent(1)[0].act_id}\n".encode())


if __name__ == "__main__":
    asyncio.run(live(Path(sys.argv[1])))
