"""The arm: where its joints are, what moves them, how fast its time runs, and its limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cellctl.sim.plant import Floats
from cellctl.sim.ur.kinematics import (
    Kinematics,
    joint_distance,
    matrix_pose,
    pose_matrix,
    rotation_vector,
)
from cellctl.sim.ur.motion import JointBrake, LineBrake, Motion
from cellctl.sim.ur.options import Six, UrOptions
from cellctl.sim.ur.trajectory import MotionError, Planner, Trajectory

_ZERO: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_FASTEST_RAMP_S = 0.05
"""Shortest time in which time on a path speeds up from standstill to its full rate."""


@dataclass
class Braking:
    """One stop that was not the program's own, from its cause to rest. Cell time, metres."""

    cause: str
    started_s: float
    speed_m_s: float
    distance_m: float = 0.0
    duration_s: float = 0.0
    at_rest: bool = False


class Arm:
    """Six joints and the motion that has hold of them.

    Time on a scalable motion runs at ``rate``, 1 at full speed. The rate follows the speed slider,
    and goes to 0 for a pause or for a stop on the path; it changes so that the leading joint is
    accelerated by no more than the option for its cause.
    """

    def __init__(self, options: UrOptions) -> None:
        self._options = options
        tolerance = options.speed_tolerance
        self._joint_speed_trip_rad_s = [v * tolerance for v in options.joint_speed_limit_rad_s]
        self._tcp_speed_trip_m_s = options.tcp_speed_limit_m_s * tolerance
        self.kinematics = Kinematics(options.model, options.joint_position_limit_rad)
        self.planner = Planner(self.kinematics, options)
        self.joints_rad: Six = options.initial_joints_rad
        self.velocity_rad_s: Six = _ZERO
        self.acceleration_rad_s2: Six = _ZERO
        self.flange = self.kinematics.flange(self.joints_rad)
        self.tcp_offset: Six = _ZERO
        self._tcp = pose_matrix(_ZERO)
        self._pose = self.flange
        self.tcp_pose = matrix_pose(self._pose)
        self.tcp_twist: Six = _ZERO
        self.rate = 1.0
        self.slider = 1.0
        self.rest_s = math.inf
        """How long the arm has been at rest."""
        self.braking: Braking | None = None
        """The last stop of the controller's own."""
        self._now_s = 0.0
        self._motion: Motion | None = None
        self._hold_rad_s2: float | None = None
        self._drop_at_rest = False
        self._nominal_rad_s = 0.0

    @property
    def tcp(self) -> Floats:
        """4x4 pose of the TCP in the flange's frame."""
        return self._tcp

    def set_tcp(self, offset: Six) -> None:
        """Take another TCP; the arm does not move."""
        self.tcp_offset = offset
        self._tcp = pose_matrix(offset)
        self._pose = self.flange @ self._tcp
        self.tcp_pose = matrix_pose(self._pose)

    @property
    def joints_array(self) -> Floats:
        """The joint positions as an array."""
        return np.array(self.joints_rad)

    @property
    def moving(self) -> bool:
        """Whether any joint moves."""
        return self.rest_s == 0.0

    @property
    def busy(self) -> bool:
        """Whether a motion has hold of the arm, at rest or not."""
        return self._motion is not None

    @property
    def tcp_speed_m_s(self) -> float:
        """Speed of the TCP."""
        return math.hypot(*self.tcp_twist[:3])

    @property
    def commanded(self) -> tuple[float, float] | None:
        """Speed and acceleration that the movement under way was given; None where there is none,
        or it is a stop. SI units of a line (m) or of joints (rad)."""
        if not isinstance(self._motion, Trajectory):
            return None
        waypoint = self._motion.waypoint
        return waypoint.speed, waypoint.acceleration

    def target_pose(self) -> Six:
        """Pose of the waypoint that is approached, or where the TCP is when there is none."""
        if not isinstance(self._motion, Trajectory):
            return self.tcp_pose
        waypoint = self._motion.waypoint
        if waypoint.kind == "line":
            return waypoint.target
        return matrix_pose(self.kinematics.flange(waypoint.target) @ self._tcp)

    def start(self, motion: Motion) -> None:
        """Follow a motion from now on, in place of the one before it."""
        self._motion = motion
        self._nominal_rad_s = 0.0
        self._drop_at_rest = False

    def follows(self, motion: Motion) -> bool:
        """Whether this motion still has hold of the arm."""
        return self._motion is motion

    def jump(self, joints_rad: Six) -> None:
        """Be somewhere else, at rest: a person has brought the arm there."""
        self.joints_rad = joints_rad
        self.flange = self.kinematics.flange(joints_rad)
        self._pose = self.flange @ self._tcp
        self.tcp_pose = matrix_pose(self._pose)

    def stop_joints(self, deceleration_rad_s2: float) -> None:
        """``stopj``: bring all joints to rest together."""
        self.start(JointBrake(self.velocity_rad_s, deceleration_rad_s2))

    def stop_line(self, deceleration_m_s2: float) -> None:
        """``stopl``: bring the TCP to rest on the line on which it moves."""
        self.start(LineBrake(self.tcp_twist, deceleration_m_s2, self._tcp, self.kinematics))

    def brake(self, cause: str, deceleration_rad_s2: float) -> None:
        """Stop on the path and let go of the motion."""
        self.hold(cause, deceleration_rad_s2)
        self._drop_at_rest = True
        if not self.moving:
            self._let_go()

    def hold(self, cause: str, deceleration_rad_s2: float) -> None:
        """Stop on the path and stay there, with the motion, until ``release``."""
        if self.moving and (self.braking is None or self.braking.at_rest):
            self.braking = Braking(cause, self._now_s, self.tcp_speed_m_s)
        if self._motion is not None and not self._motion.scalable:
            self._motion = JointBrake(self.velocity_rad_s, deceleration_rad_s2)
            self._drop_at_rest = True
        if self._hold_rad_s2 is None or deceleration_rad_s2 > self._hold_rad_s2:
            self._hold_rad_s2 = deceleration_rad_s2

    def abandon(self, cause: str, deceleration_rad_s2: float) -> None:
        """Stop off the path, because the path cannot be followed any further."""
        if isinstance(self._motion, JointBrake):
            # Not even braking is possible within the limits: the joints' end stops hold the arm.
            self._let_go()
            return
        if self.moving:
            self.braking = Braking(cause, self._now_s, self.tcp_speed_m_s)
        self.stop_joints(deceleration_rad_s2)

    def release(self) -> None:
        """End a hold: the motion goes on. A stop that lets go of the motion is carried through."""
        if not self._drop_at_rest:
            self._hold_rad_s2 = None

    def advance(self, duration_s: float) -> None:
        """Move for a time (at most 8 ms).

        Raises:
            MotionError: a limit is exceeded or a point is out of reach; the arm has not moved.
        """
        self._now_s += duration_s
        self._change_rate(duration_s)
        before = self.joints_rad
        after = before
        if self._motion is not None:
            time_s = duration_s * (self.rate if self._motion.scalable else 1.0)
            after = self._advanced(self._motion, time_s, before)
        self._place(after, duration_s)
        if self._motion is not None and self._motion.done:
            self._let_go()
        if self._drop_at_rest and not self.moving:
            self._let_go()

    def _advanced(self, motion: Motion, time_s: float, before: Six) -> Six:
        if time_s <= 0.0:
            return before
        try:
            after = motion.advance(time_s, before)
        except MotionError:
            if not isinstance(motion, LineBrake):
                raise
            # A straight stop that leaves the arm's reach goes on as a stop of the joints.
            self.stop_joints(self._options.program_stop_rad_s2)
            return before
        if motion.scalable:
            self._nominal_rad_s = joint_distance(before, after) / time_s
        return after

    def _change_rate(self, duration_s: float) -> None:
        holding = self._hold_rad_s2
        wanted = self.slider if holding is None else 0.0
        if self.rate == wanted:
            return
        limit_rad_s2 = self._options.speed_slider_rad_s2 if holding is None else holding
        ramp_s = max(_FASTEST_RAMP_S if wanted > self.rate else 0.0, 1e-9)
        if self._motion is not None and self._motion.scalable:
            ramp_s = max(ramp_s, self._nominal_rad_s / limit_rad_s2)
        step = duration_s / ramp_s
        if wanted > self.rate:
            self.rate = min(wanted, self.rate + step)
        else:
            self.rate = max(wanted, self.rate - step)

    def _check_joints(self, joints_rad: Six, velocity_rad_s: Six) -> None:
        options = self._options
        if not self.kinematics.within_limits(joints_rad):
            for i, most in enumerate(options.joint_position_limit_rad):
                if abs(joints_rad[i]) > max(most, abs(self.joints_rad[i])):
                    raise MotionError(f"joint {i} is at its position limit")
        for i, most in enumerate(self._joint_speed_trip_rad_s):
            if abs(velocity_rad_s[i]) > most:
                raise MotionError(f"joint {i} exceeds its speed limit")

    def _place(self, joints_rad: Six, duration_s: float) -> None:
        """Take new joint positions and work out the speeds.

        Raises:
            MotionError: they, or the speeds, are beyond a limit. Nothing is taken then.
        """
        if joints_rad == self.joints_rad:
            self._rest(duration_s)
            return
        if not math.isfinite(sum(joints_rad)):
            raise MotionError("a joint position is not a number")
        velocity = _rates(self.joints_rad, joints_rad, duration_s)
        self._check_joints(joints_rad, velocity)
        flange = self.kinematics.flange(joints_rad)
        pose = flange @ self._tcp
        before, after = self._pose.tolist(), pose.tolist()
        vx, vy, vz = ((after[i][3] - before[i][3]) / duration_s for i in range(3))
        speed_m_s = math.hypot(vx, vy, vz)
        if speed_m_s > self._tcp_speed_trip_m_s:
            raise MotionError("the TCP exceeds its speed limit")
        if self._options.tcp_box_m is not None and not isinstance(self._motion, JointBrake):
            self._check_box(pose)
        turn = rotation_vector(pose[:3, :3] @ self._pose[:3, :3].T)
        wx, wy, wz = (angle / duration_s for angle in turn)
        self.acceleration_rad_s2 = _rates(self.velocity_rad_s, velocity, duration_s)
        self.velocity_rad_s = velocity
        self.tcp_twist = (vx, vy, vz, wx, wy, wz)
        self.joints_rad = joints_rad
        self.flange = flange
        self._pose = pose
        self.tcp_pose = matrix_pose(pose)
        self.rest_s = 0.0
        if self.braking is not None and not self.braking.at_rest:
            self.braking.distance_m += speed_m_s * duration_s
            self.braking.duration_s += duration_s

    def _rest(self, duration_s: float) -> None:
        if self.moving:
            self.velocity_rad_s = self.acceleration_rad_s2 = self.tcp_twist = _ZERO
            if self.braking is not None:
                self.braking.at_rest = True
        self.rest_s += duration_s

    def _check_box(self, pose: Floats) -> None:
        assert self._options.tcp_box_m is not None
        low, high = self._options.tcp_box_m
        before = self.tcp_pose
        for i, (least, most) in enumerate(zip(low, high, strict=True)):
            value = float(pose[i, 3])
            outward = value < min(least, before[i]) or value > max(most, before[i])
            if outward:
                raise MotionError("the TCP leaves the space that it is limited to")

    def _let_go(self) -> None:
        self._motion = None
        if self._drop_at_rest:
            self._hold_rad_s2 = None
        self._drop_at_rest = False
        self._nominal_rad_s = 0.0


def _rates(before: Six, after: Six, duration_s: float) -> Six:
    a0, a1, a2, a3, a4, a5 = before
    b0, b1, b2, b3, b4, b5 = after
    return (
        (b0 - a0) / duration_s,
        (b1 - a1) / duration_s,
        (b2 - a2) / duration_s,
        (b3 - a3) / duration_s,
        (b4 - a4) / duration_s,
        (b5 - a5) / duration_s,
    )
