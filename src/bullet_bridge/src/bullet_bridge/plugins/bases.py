"""Bases that are moved by forces, by a tricycle's wheel or by many wheels."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from bullet_sim.controllers.bases import RIGHT_ANGLE, TricycleMotion, after_arc
from bullet_sim.models.actor import FRAME
from bullet_sim.plugins.bases import (
    HIPS,
    ForceMoveSpec,
    ManyWheelsSpec,
    TricycleSpec,
    WalkerSpec,
)
from bullet_sim.pose import Pose, Vec3, quaternion_from_yaw, rpy_from_quaternion
from bullet_sim.sensors import inertial
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from bullet_bridge.plugins.base import ModelPlugin, PluginContext, ros_side
from bullet_bridge.plugins.drives import PlanarMovePlugin, command_of, planar_motion
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedBase

TURNING = 100.0  # variance of yaw and its rate while a base moved by forces turns
STILL = 1e-4  # [rad/s] below which it does not turn


@ros_side(ForceMoveSpec)
class ForceMovePlugin(PlanarMovePlugin):
    """Pushes and turns a link in every step; publishes Odometry and its transform."""

    STATE = ("_pose2d", "_sent_at", "_held")

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        self._index, _ = self.model.link_in_body(spec.base)
        transform = self._transform if spec.publish_tf else None
        frames, odometry = (spec.frame_id, spec.child_frame_id), self._odometry
        turning = replace(
            spec,
            pose_covariance=(*spec.pose_covariance[:5], TURNING),
            twist_covariance=(*spec.twist_covariance[:5], TURNING),
        )
        self._senders = [
            PackedBase(odometry, transform, each, frames) for each in (spec, turning)
        ]  # standing and turning

    def start(self, time: float) -> None:
        """Messages from now on."""
        super().start(time)
        self._sent_at = time

    def reset(self, time: float) -> None:
        """Without a command, odometry at zero."""
        self._pose2d = (0.0, 0.0, 0.0)
        self._held: Pose | None = None  # where it stays, without a command
        super().reset(time)

    def update(self, time: float, period: float) -> None:
        spec, model = self.spec, self.model
        if self._new:
            self._since, self._new, self._held = time, False, None
        is_late = 0.0 <= spec.timeout < time - (self._since or 0.0)
        if is_late:
            self._command = (0.0, 0.0, 0.0)
        position, orientation, linear, angular = model.link_motion(spec.link)
        own, turning = inertial.twist(orientation, linear, angular)
        x, y, yaw_rate = map(min, self._command, spec.maxima)
        gain_x, gain_y, gain_yaw = spec.gains
        push = np.array(((x - own[0]) * gain_x, (y - own[1]) * gain_y, 0.0))
        turn = np.array((0.0, 0.0, (yaw_rate - angular[2]) * gain_yaw))
        if push.any() or turn.any():
            rotation = model.link_state(spec.base)[0].matrix
            model.apply_wrench(self._index, rotation @ push, turn)
        if spec.holds and is_late:
            self._held = self._held or Pose(position, orientation)
            model.set_state(self._held)
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


class DrivenBase(ModelPlugin):
    """Takes velocity commands, publishes Odometry and its transform at the rate of its commands."""

    STATE: ClassVar[tuple[str, ...]] = ("_command", "_before")
    reports = True

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        self._odometry = self.publisher(spec.topic, Odometry)
        self._tf = self.publisher("/tf", TFMessage)
        self._sender = PackedBase(*self._outputs(), spec, (spec.frame_id, spec.child_frame_id))

    def _outputs(self) -> tuple[Any, Any]:
        """Publishers of odometry and its transform, or None."""
        return self._odometry, self._tf

    def listen(self) -> None:
        """Subscribe to the velocity commands."""
        self.subscribe(self.spec.command_topic, Twist, self._on_command)

    def start(self, time: float) -> None:
        """The next update is the first."""
        self._before = time

    def reset(self, time: float) -> None:
        """Without a command."""
        self._command: tuple[float, ...] = (0.0, 0.0)
        super().reset(time)

    def _on_command(self, message: Any) -> None:
        command = command_of(self.spec.command_topic, (message.linear.x, message.angular.z))
        if command is not None:
            self._command = command

    def _elapsed(self, time: float) -> float:
        """Time since the last update [s]."""
        before, self._before = self._before, time
        return time - before

    def _true_motion(self) -> Any:
        """The model's pose; its velocity along the axes of its heading, yaw rate in the world."""
        return planar_motion(self.model.link_motion(self.spec.link))


@ros_side(TricycleSpec)
class TricyclePlugin(DrivenBase):
    """Drives and steers one wheel by geometry_msgs/Twist: speed [m/s] and steering angle [rad]."""

    STATE = ("_motion",)
    resets = False

    def __init__(self, context: PluginContext) -> None:
        self._motion = TricycleMotion(context.spec)
        super().__init__(context)
        spec = self.spec
        topic = spec.wheel_states_topic
        self._wheel_states = self.publisher(topic, JointState) if topic else None
        self._names = [spec.steering, spec.wheel, *spec.encoders]

    def reset(self, time: float) -> None:
        """Without a command, odometry at zero."""
        self._motion.restart()
        super().reset(time)

    def prepare(self) -> None:
        """The driven wheel and its steering are braked until the first update."""
        for joint in self._names[:2]:
            self.model.joints.set_motor(joint, 0.0, self.spec.torque)

    def update(self, time: float, period: float) -> None:
        spec, joints, motion = self.spec, self.model.joints, self._motion
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
        spec, motion = self.spec, self._motion
        if spec.from_wheels:
            (x, y, yaw), (vx, vy, rate) = motion.pose, motion.twist
            turn = quaternion_from_yaw(yaw)
            self._sender.send(time, (x, y, 0.0), turn, (vx, vy, 0.0), (0.0, 0.0, rate))
        else:
            self._sender.send(time, *self._true_motion())
        if spec.wheel_frames:
            self._tf.publish(TFMessage(self._wheel_transforms(time)))
        if self._wheel_states is not None:
            joints = self.model.joints
            efforts = joints.columns([joints.names.index(name) for name in self._names])[2]
            self._wheel_states.publish(
                JointState(
                    header=conversions.header(time),
                    name=self._names,
                    position=[positions[name] for name in self._names],
                    velocity=[speeds[name] for name in self._names],
                    effort=efforts,
                )
            )

    def _wheel_transforms(self, time: float) -> list[Any]:
        """As upstream: named by the joints, below their parents, with the poses in the model."""
        root = self.model.link_state(self.spec.link)[0].inverse()
        return [
            conversions.transform_to_msg(
                time,
                parent,
                child,
                root * self.model.link_state(self.model.description.joints[name].child)[0],
            )
            for name, (parent, child) in zip(self._names, self.spec.wheel_frames)
        ]


@ros_side(ManyWheelsSpec)
class ManyWheelsPlugin(DrivenBase):
    """Gives the wheels of each side their velocity, whatever the torque that it takes."""

    @property
    def resets_with_model(self) -> bool:
        """Whether a reset of its model alone resets it."""
        return self.spec.resets

    def _outputs(self) -> tuple[Any, Any]:
        spec = self.spec
        return (
            self._odometry if spec.publish_odometry else None,
            self._tf if spec.publish_tf else None,
        )

    def update(self, time: float, period: float) -> None:
        spec = self.spec
        if spec.publish_odometry or spec.publish_tf:
            position, orientation, linear, angular = self._true_motion()
            self._sender.send(time, position, orientation, linear, angular, flat=True)
        forward, yaw_rate = self._command
        half = yaw_rate * spec.separation / 2.0
        for wheels, speed in ((spec.left, forward - half), (spec.right, forward + half)):
            speeds = [speed / (spec.diameter / 2.0)] * len(wheels)
            self.model.joints.impose_velocities(wheels, speeds)


# Of Gazebo's ActorPlugin.
PACE = 0.8  # [m/s] times the weight of the target
ARRIVED, APART, ASIDE = 0.3, 2.0, 4.0  # [m] to targets, between targets and models, to obstacles
BOUNDS = ((-3.0, 3.5), (-10.0, 2.0))  # [m] of x and y, between which it stays
TURN, SIDE = 0.001, 1.5707  # part of a turn in each step; its yaw is that far left of its way [rad]
TRIES = 1000  # targets by chance, after which it keeps the last one


@ros_side(WalkerSpec)
class WalkerPlugin(ModelPlugin):
    """Walks an actor to targets: it turns on the spot, then goes, and is pushed away from models.

    Between two updates, of as many steps as an actor's frame has, models are taken to stand still.
    """

    STATE = ("_place", "_target", "_way")

    def _rate(self) -> float:
        return 1.0 / FRAME if self.world.time_step < FRAME else 1.0 / self.world.time_step

    def prepare(self) -> None:
        """Show it where it is (simulation thread)."""
        self._show()

    def reset(self, time: float) -> None:
        """Go from where the file puts it to the first target."""
        motion = self.model.description.motion
        x, y, _ = motion.pose.position
        self._place = (x, y, rpy_from_quaternion(motion.pose.orientation)[2])
        self._target: Vec3 = self.spec.target
        self._way = 0.0
        super().reset(time)
        self._show()

    def _show(self) -> None:
        x, y, yaw = self._place
        pose = Pose((x, y, 0.0), quaternion_from_yaw(yaw - SIDE))
        engine: Any = self.model.engine  # an ActorEngine
        engine.walk_to(pose, self._way)

    def _obstacles(self, ignored: tuple[str, ...]) -> list[Vec3]:
        """Positions of other models; those of actors at the height of its own."""
        return [
            (x, y, HIPS if model.description.motion is not None else z)
            for name, model in self.world.models.items()
            if name not in ignored
            for x, y, z in (model.pose.position,)
        ]

    def update(self, time: float, period: float) -> None:
        step = self.world.time_step
        others = self._obstacles((*self.spec.ignored, self.model.name))
        for _ in range(max(1, round((time - self.updated) / step))):
            self._walk(step, others)
        self.updated = time
        self._show()

    def _walk(self, step: float, others: list[Vec3]) -> None:
        """Turn or go for a step [s]."""
        x, y, yaw = self._place
        if math.dist(self._target, (x, y, HIPS)) < ARRIVED:
            self._choose()
        away = [goal - own for goal, own in zip(self._target, (x, y, HIPS))]
        factor = self.spec.weight / (math.hypot(*away) or 1.0)
        go_x, go_y = away[0] * factor, away[1] * factor
        for other in others:
            offset = [place - own for place, own in zip(other, (x, y, HIPS))]
            distance = math.hypot(*offset)
            if 0.0 < distance < ASIDE:
                push = self.spec.obstacle_weight / distance**2
                go_x, go_y = go_x - push * offset[0], go_y - push * offset[1]
        turn = math.remainder(math.atan2(go_y, go_x) + SIDE - yaw, 2.0 * math.pi)
        if abs(turn) > math.radians(10.0):
            yaw += turn * TURN
        else:
            yaw, x, y = yaw + turn, x + go_x * PACE * step, y + go_y * PACE * step
        x, y = (min(max(value, low), high) for value, (low, high) in zip((x, y), BOUNDS))
        self._way += math.hypot(x - self._place[0], y - self._place[1])
        self._place = (x, y, math.remainder(yaw, 2.0 * math.pi))

    def _choose(self) -> None:
        """A target by chance, away from the last one and from all models."""
        x, y, _ = self._place
        models = [*self._obstacles((self.model.name,)), (x, y, HIPS)]
        for _ in range(TRIES):
            target = (*(float(self.rng.uniform(*bounds)) for bounds in BOUNDS), self._target[2])
            if all(math.dist(target, place) >= APART for place in (self._target, *models)):
                self._target = target  # type: ignore[assignment]
                return
