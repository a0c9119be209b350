"""The arm and its gripper: kinematics, routes, and the process that talks to the robot."""
