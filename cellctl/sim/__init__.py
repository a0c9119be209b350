"""The emulated cell: one world, and emulators of robot, conveyor and gripper that share it.

Never imported by the rooms below; shares no code with the planner.
"""
