"""A client that moves the arm along a path and kicks the watchdog, until it is killed.

Run as ``python -m tests.sim.ur.moving_client HOST``; prints ``moving`` when the arm does.
"""

from __future__ import annotations

import sys
import threading

from rtde_control import RTDEControlInterface
from rtde_receive import RTDEReceiveInterface

SPEED_M_S = 0.5
KICK_S = 0.02


def main() -> None:
    host = sys.argv[1]
    receive = RTDEReceiveInterface(host)
    control = RTDEControlInterface(host)
    x, y, z, *turn = receive.getActualTCPPose()
    path = [
        [x, y, z + 0.2, *turn, SPEED_M_S, 1.2, 0.05],
        [x, y + 0.5, z + 0.2, *turn, SPEED_M_S, 1.2, 0.0],
    ]
    control.moveL(path, True)
    # A path uploads the program anew, which drops the watchdog: it is armed after, not before.
    control.setWatchdog(10.0)
    told = False
    pause = threading.Event()
    while True:
        control.kickWatchdog()
        if not told and abs(receive.getActualTCPSpeed()[1]) > 0.95 * SPEED_M_S:
            sys.stdout.write("moving\n")
            sys.stdout.flush()
            told = True
        pause.wait(KICK_S)


if __name__ == "__main__":
    main()
