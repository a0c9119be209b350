"""The emulated UR controller: the unmodified ``ur_rtde`` clients connect, move and fail against it.

It speaks what a robot's controller speaks on its network ports: RTDE (30004), URScript (30003) and
the dashboard (29999). What it emulates, and what it only assumes, is listed in
``docs/emulated-controller.md``.
"""
