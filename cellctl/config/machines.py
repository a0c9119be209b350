"""The tables of what moves: arm, gripper, conveyor."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cellctl.config.section import Joints, Port, Pose, Positive, Section

Baud = Literal[9600, 19200, 38400, 57600, 115200]
BoardSerial = Annotated[str | None, Field(pattern="^[0-9A-F]{1,20}$")]


class RobotSection(Section):
    """The arm and its controller."""

    model: Literal["ur10", "ur10e"]
    """What the controller must say that it is; another one is a fault."""
    host: Annotated[str, Field(min_length=1)]
    """Name or address of the robot's controller."""
    dashboard_port: Port = 29999
    """TCP port of its dashboard server; the other ports are fixed."""
    rtde_frequency_hz: Literal[125, 500]
    """How often the controller reports; a ur10 (CB3) knows 125 only."""
    home_rad: Joints
    """Where the arm rests between jobs, clear of everything."""
    travel_speed_m_s: Annotated[float, Field(gt=0.0, le=3.0)]
    """Speed of the TCP between feeder and workspace."""
    travel_acceleration_m_s2: Annotated[float, Field(gt=0.0, le=20.0)]
    """Acceleration of the TCP, in its curves too."""
    carrying_speed_m_s: Annotated[float, Field(gt=0.0, le=3.0)] = 3.0
    """The most with a part in the gripper, and where an empty one comes to touch a part, where that
    is less."""
    carrying_acceleration_m_s2: Annotated[float, Field(gt=0.0, le=20.0)] = 20.0
    """The most with a part in the gripper, and where an empty one comes to touch a part, where that
    is less."""
    carrying_measured: Annotated[str, Field(max_length=200)] = ""
    """What these two rest on: date, object and how often it stood; `cellctl calibrate speed` writes
    all three."""
    joint_speed_fraction: Annotated[float, Field(gt=0.0, le=1.0)] = 0.95
    """How much of its joints' greatest speeds the arm uses."""
    joint_acceleration_rad_s2: Annotated[float, Field(gt=0.0, le=40.0)] = 5.2
    """Greatest acceleration of a joint; the makers publish none."""
    approach_speed_m_s: Annotated[float, Field(gt=0.0, le=1.0)]
    """Speed over the last stretch, where parts touch."""
    approach_acceleration_m_s2: Annotated[float, Field(gt=0.0, le=20.0)] = 1.0
    """Acceleration on that stretch."""
    approach_height_m: Annotated[float, Field(gt=0.0, le=0.2)]
    """Length of that stretch."""
    path: Literal["blended", "square"] = "blended"
    """``blended``: rounded, as low as is safe, slow where parts touch; ``square``: the paper's, up
    to one plane above everything, across and down, with a rest at every corner."""
    blend_radius_m: Annotated[float, Field(ge=0.0, le=0.3)]
    """How round the corners of a path may be; 0 stops at each."""
    clearance_m: Annotated[float, Field(gt=0.0, le=0.3)]
    """Least distance between a carried part and what it crosses."""
    margin_m: Annotated[float, Field(ge=0.003, le=0.1)] = 0.01
    """Least distance between anything of the arm and anything else, but beside and above the spot
    where it picks or places."""
    touch_depth_m: Annotated[float, Field(ge=0.0, le=0.0015)] = 0.0007
    """How far below its seat a part is pressed that a column carries, and how far above it the
    gripper is felt to be free after letting go; 0 feels nothing."""
    touch_force_n: Annotated[float, Field(gt=0.0, le=50.0)] = 6.0
    """What a force sensor (ur10e) must feel there to count as touching."""
    early_force_n: Annotated[float, Field(gt=0.0, le=100.0)] = 35.0
    """A part that is pressed up with more, on its way down or where it is pressed on, has met
    something too early."""
    touch_lag_m: Annotated[float, Field(ge=0.0001, le=0.0015)] = 0.0003
    """An arm without such a sensor (ur10) touches where it is this far from where its controller
    wants it."""
    early_lag_m: Annotated[float, Field(ge=0.0005, le=0.01)] = 0.0018
    """The same of what is met too early."""
    following_s: Annotated[float, Field(ge=0.0, le=0.2)] = 0.016
    """How far behind such an arm may be while it moves, as a time at its speed, beyond that."""
    real_time_priority: Annotated[int, Field(ge=0, le=5)] = 0
    """Priority of the arm process among what runs in real time; 0: an ordinary process, with
    niceness -10. Where a browser and a recogniser share two cores with it, that is not always
    enough for the watchdog; real time is, and costs a sixth of a core more."""
    watchdog_hz: Annotated[float, Field(ge=5.0, le=50.0)] = 10.0
    """The controller stops the arm when it hears nothing for one period of this."""
    host_silence_s: Annotated[float, Field(ge=0.2, le=5.0)] = 1.0
    """The arm process stops the arm when the daemon says nothing for this long (wall time)."""
    connect_timeout_s: Positive = 10.0
    """For connecting to the controller and starting its program."""
    move_timeout_factor: Annotated[float, Field(ge=1.2, le=20.0)] = 3.0
    """A movement that takes this many times its planned duration, plus 2 s, is a fault."""

    @model_validator(mode="after")
    def _can_feel(self) -> Self:
        """Pressing must move an arm without a force sensor by more than what counts as touching."""
        if self.model != "ur10" or not self.touch_depth_m:
            return self
        if self.touch_lag_m > 0.6 * self.touch_depth_m:
            raise ValueError(
                "touch_lag_m must be at most 0.6 of touch_depth_m: a part is pressed no deeper, so "
                "that it would never be felt."
            )
        if self.early_lag_m <= self.touch_depth_m:
            raise ValueError(
                "early_lag_m must be more than touch_depth_m: every part that is seated as it "
                "should be would have met something too early."
            )
        return self


class GripperSection(Section):
    """The gripper's lines on the robot's controller. High on the command line unlatches."""

    command_output: Annotated[int, Field(ge=0, le=7)]
    """Standard digital output."""
    status_input: Annotated[int, Field(ge=0, le=7)]
    """Standard digital input; high while a completed latch is confirmed."""
    travel_timeout_s: Positive
    """For the latch to move and say so (cell time)."""
    latch_s: Positive = 0.35
    """How long the latch takes to close, for times that are told in advance (cell time)."""
    release_s: Positive = 0.5
    """How long the latch takes to open at most, which no line tells (cell time); its board's serial
    port, where connected, tells when it is over."""
    retries: Annotated[int, Field(ge=0, le=5)] = 1
    """How often a silent gripper or a missed pick is tried again before it is a fault."""
    port: Annotated[str | None, Field(min_length=1)] = None
    """Serial port of the gripper's board, which tells more than the two lines; none: it is not
    connected. The lines command the latch either way."""
    baud: Baud = 115200
    """Bits per second on that port."""
    serial_number: BoardSerial = None
    """Serial number that the board must have; none: any."""
    reply_timeout_s: Positive = 0.3
    """For one line's answer (wall time); a line is sent again twice before the board is lost."""


class FeederSection(Section):
    """The conveyor that brings parts."""

    frame: Pose
    """Centre of the top face of the part that waits at the pick station; x along the feed."""
    port: Annotated[str, Field(min_length=1)]
    """Serial port of the conveyor's board."""
    baud: Baud = 115200
    """Bits per second on that port."""
    serial_number: BoardSerial = None
    """Serial number that the board must have; none: any."""
    capacity_parts: Annotated[int, Field(ge=1, le=1000)]
    """How many parts a full belt holds."""
    width_m: Positive
    """Width of the belt, an obstacle."""
    reply_timeout_s: Positive = 0.3
    """For one line's answer (wall time); a line is sent again twice before the board is lost."""
    reconnect_timeout_s: Annotated[float, Field(ge=0.0, le=60.0)] = 3.0
    """How long a board that is lost in the middle of a build is looked for (wall time)."""
    index_timeout_s: Positive = 10.0
    """For bringing one part to the pick station (cell time)."""
    retries: Annotated[int, Field(ge=0, le=5)] = 1
    """How often an index that brought nothing is tried again before it is a fault."""
