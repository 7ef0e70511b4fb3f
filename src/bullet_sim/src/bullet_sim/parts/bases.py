"""Bases that are moved by forces, by a tricycle's wheel or by many wheels."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from bullet_sim.controllers.bases import RIGHT_ANGLE, TricycleMotion, after_arc
from bullet_sim.parts.base import part_of
from bullet_sim.parts.drives import DrivenBase, PlanarMovePlugin
from bullet_sim.parts.outputs import JointStatesOutput, TransformsOutput
from bullet_sim.plugins.bases import ForceMoveSpec, ManyWheelsSpec, TricycleSpec
from bullet_sim.pose import Pose, quaternion_from_yaw
from bullet_sim.sensors import inertial

TURNING = 100.0  # variance of yaw and its rate while a base moved by forces turns
STILL = 1e-4  # [rad/s] below which it does not turn


@part_of(ForceMoveSpec)
class ForceMovePlugin(PlanarMovePlugin):
    """Pushes and turns a link in every step; publishes Odometry and its transform."""

    STATE: ClassVar[tuple[str, ...]] = ("_pose2d", "_sent_at", "_held", "_is_held")

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        self._part, _ = self.model.link_in_body(spec.base)
        turning = replace(
            spec,
            pose_covariance=(*spec.pose_covariance[:5], TURNING),
            twist_covariance=(*spec.twist_covariance[:5], TURNING),
        )
        self._senders = [self._sender, self.output(self._odometry(turning))]

    def _sends(self) -> tuple[bool, bool]:
        return True, self.spec.publish_tf

    def start(self, time: float) -> None:
        """Messages from now on."""
        super().start(time)
        self._sent_at = time

    def reset(self, time: float) -> None:
        """Without a command, odometry at zero."""
        self._pose2d = (0.0, 0.0, 0.0)
        self._held: Pose | None = None  # where it stays, without a command
        self._is_held = False
        super().reset(time)

    def update(self, time: float, period: float) -> None:
        spec, model = self.spec, self.model
        if self._new:
            self._since, self._new = time, False
        is_late = 0.0 <= spec.timeout < time - (self._since or 0.0)
        position, orientation, linear, angular = model.link_motion(spec.link)
        if spec.holds and is_late:  # without odometry, as upstream
            if not self._is_held:
                self.log_warning(
                    f"PlanarMovePlugin (ns = {model.name}): Robot stopped and pose forced to "
                    "prevent slipping away."
                )
            self._is_held = True
            model.set_state(self._held or Pose(position, orientation))
            return
        self._held, self._is_held = Pose(position, orientation), False
        if is_late:
            self._command = self.standing
        own, turning = inertial.twist(orientation, linear, angular)
        x, y, yaw_rate = map(min, self._command, spec.maxima)
        gain_x, gain_y, gain_yaw = spec.gains
        push = np.array(((x - own[0]) * gain_x, (y - own[1]) * gain_y, 0.0))
        turn = np.array((0.0, 0.0, (yaw_rate - angular[2]) * gain_yaw))
        if push.any() or turn.any():
            rotation = model.link_state(spec.base)[0].matrix
            model.apply_wrench(self._part, rotation @ push, turn)
        if spec.rate > 0.0 and self._due.due(self.world.step_count):
            self._publish(time, own, turning)

    def _publish(self, time: float, linear: Any, angular: Any) -> None:
        """Add the velocity [m/s, rad/s] since the last message to the odometry, and publish it."""
        elapsed, self._sent_at = time - self._sent_at, time
        sideways = linear[1] if self.spec.sideways else 0.0
        self._pose2d = after_arc(self._pose2d, linear[0], sideways, angular[2], elapsed)
        x, y, yaw = self._pose2d
        self._senders[abs(angular[2]) >= STILL].send(
            time,
            (x, y, 0.0),
            quaternion_from_yaw(yaw),
            (linear[0], sideways, 0.0),
            (0.0, 0.0, angular[2]),
        )


@part_of(TricycleSpec)
class TricyclePlugin(DrivenBase):
    """Drives and steers one wheel by geometry_msgs/Twist: speed [m/s] and steering angle [rad]."""

    STATE: ClassVar[tuple[str, ...]] = ("_tricycle",)
    resets = False
    waits_for_time = True

    def __init__(self, context: Any) -> None:
        self._tricycle = TricycleMotion(context.spec)
        super().__init__(context)
        spec = self.spec
        topic = spec.wheel_states_topic
        names = self._names = (spec.steering, spec.wheel, *spec.encoders)
        self._wheel_states = self.output(JointStatesOutput(topic, names)) if topic else None
        self._wheel_frames = self.output(TransformsOutput()) if spec.wheel_frames else None

    def reset(self, time: float) -> None:
        """Without a command, odometry at zero."""
        self._tricycle.restart()
        super().reset(time)

    def prepare(self) -> None:
        """The driven wheel and its steering are braked until the first update."""
        for joint in self._names[:2]:
            self.model.joints.set_motor(joint, 0.0, self.spec.torque)

    def update(self, time: float, period: float) -> None:
        spec, joints, motion = self.spec, self.model.joints, self._tricycle
        positions, speeds = joints.state()
        if spec.from_wheels:
            motion.measure(time, *(speeds[name] for name in spec.encoders))
        self._publish(time, positions, speeds)
        elapsed = self._elapsed(time)
        speed, angle = self._command
        target = speed / (spec.diameter / 2.0)
        wheel = motion.wheel_speed(target, speeds[spec.wheel], elapsed)
        joints.set_motor(spec.wheel, wheel, spec.torque)
        if spec.steering_speed > 0.0:
            turn = motion.steering_speed(angle, positions[spec.steering], target)
            joints.set_motor(spec.steering, turn, spec.torque)
        else:
            angle = max(-RIGHT_ANGLE, min(RIGHT_ANGLE, angle))
            joints.set_positions({spec.steering: angle})

    def _publish(self, time: float, positions: Any, speeds: Any) -> None:
        spec, motion = self.spec, self._tricycle
        if spec.from_wheels:
            (x, y, yaw), (vx, vy, rate) = motion.pose, motion.twist
            turn = quaternion_from_yaw(yaw)
            self._sender.send(time, (x, y, 0.0), turn, (vx, vy, 0.0), (0.0, 0.0, rate))
        else:
            self._sender.send(time, *self._motion())
        if self._wheel_frames is not None:
            self._wheel_frames.send(time, self._frames_of(zip(self._names, spec.wheel_frames)))
        if self._wheel_states is not None:
            joints = self.model.joints
            efforts = joints.columns([joints.names.index(name) for name in self._names])[2]
            self._wheel_states.send(
                time,
                [positions[name] for name in self._names],
                [speeds[name] for name in self._names],
                efforts,
            )


@part_of(ManyWheelsSpec)
class ManyWheelsPlugin(DrivenBase):
    """Gives the wheels of each side their velocity, whatever the torque that it takes."""

    waits_for_time = True
    advertises = True

    def _sends(self) -> tuple[bool, bool]:
        return self.spec.publish_odometry, self.spec.publish_tf

    def update(self, time: float, period: float) -> None:
        spec = self.spec
        if spec.publish_odometry or spec.publish_tf:
            position, orientation, linear, angular = self._motion()
            self._sender.send(time, position, orientation, linear, angular, flat=True)
        forward, yaw_rate = self._command
        half = yaw_rate * spec.separation / 2.0
        for wheels, speed in ((spec.left, forward - half), (spec.right, forward + half)):
            speeds = [speed / (spec.diameter / 2.0)] * len(wheels)
            self.model.joints.impose_velocities(wheels, speeds)
