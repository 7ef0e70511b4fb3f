"""Transforms from the simulator itself: a model's joints, and its root link in the world."""

from __future__ import annotations

import math
import threading
from typing import TYPE_CHECKING, Any

from bullet_sim.plugins.transforms import JointTransformsSpec, RootTransformSpec
from bullet_sim.pose import Pose, Quat, Vec3, compose, multiply
from tf2_msgs.msg import TFMessage

from bullet_bridge.plugins.base import PluginContext, Sensor, ros_side
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedTransforms
from bullet_bridge.transport.publishing import publisher

if TYPE_CHECKING:
    from bullet_sim.description.model import Joint


NO_ROTATION = (0.0, 0.0, 0.0, 1.0)


class FixedTransforms:
    """/tf_static of all models: latched, so that each message has to contain them all.

    A publisher stores its last message only; this one exists as long as there are transforms.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._publisher: Any = None
        self._of: dict[object, list[Any]] = {}

    def put(self, owner: object, transforms: list[Any]) -> None:
        """Set an owner's transforms (TransformStamped; empty: remove them) and publish all."""
        with self._lock:
            self._of.pop(owner, None)
            if transforms:
                self._of[owner] = transforms
            if self._publisher is not None and self._publisher.impl is None:
                self._publisher = None  # unregistered: what else was to be made with it failed
            if self._publisher is None and self._of:
                self._publisher = publisher("/tf_static", TFMessage, latch=True)
            if self._publisher is not None:
                together = [item for items in self._of.values() for item in items]
                self._publisher.publish(TFMessage(together))


_fixed = FixedTransforms()


@ros_side(JointTransformsSpec)
class JointTransformsSensor(Sensor):
    """What robot_state_publisher publishes, from the engine's positions: moving joints on /tf, at
    the rate of the specification, fixed ones latched on /tf_static.
    """

    message = TFMessage
    reports = False  # others publish on /tf, too
    watches, tells_velocities = True, False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        model, prefix = self.model, self.spec.prefix
        joints = model.description.joints.values()
        self._moving = [joint for joint in joints if joint.name in model.joints.names]
        self._names = [joint.name for joint in self._moving]
        self._frames = [JointFrame(joint) for joint in self._moving]
        self._packed = PackedTransforms(
            self.pub, [(prefix + joint.parent, prefix + joint.child) for joint in self._moving]
        )
        fixed = [
            joint for joint in joints if joint.name not in model.joints.names and not joint.holds
        ]
        self._fixed = [
            conversions.transform_to_msg(
                self.world.time, prefix + joint.parent, prefix + joint.child, joint.origin
            )
            for joint in fixed
        ]
        _fixed.put(self, self._fixed)

    def update(self, time: float, period: float) -> None:
        positions = self.model.joints.positions_of(self._names)
        self._packed.send(time, list(map(JointFrame.at, self._frames, positions)))

    def close(self) -> None:
        super().close()
        _fixed.put(self, [])


@ros_side(RootTransformSpec)
class RootTransformSensor(Sensor):
    """The true pose of a model's root link in the world, on /tf."""

    message = TFMessage
    reports = False
    watches, tells_velocities = True, False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        self._packed = PackedTransforms(
            self.pub, [(spec.frame_id, spec.child_frame_id or spec.link)]
        )

    def update(self, time: float, period: float) -> None:
        self._packed.send(time, [self.model.link_motion(self.spec.link)[:2]])


class JointFrame:
    """The child link's frame in the parent link's, by the joint's position."""

    def __init__(self, joint: Joint) -> None:
        anchored = joint.anchor != Pose()
        origin = joint.origin * joint.anchor if anchored else joint.origin
        self._origin, self._orientation = origin.position, origin.orientation
        self._back = joint.anchor.inverse() if anchored else None
        self._axis, self._slides = joint.axis, joint.kind == "prismatic"

    def at(self, value: float) -> tuple[Vec3, Quat]:
        """Position [m] and orientation (x, y, z, w) for a position [rad, m]."""
        x, y, z = self._axis
        position, orientation = self._origin, self._orientation
        if self._slides:
            offset = (x * value, y * value, z * value)
            position, orientation = compose(position, orientation, offset, NO_ROTATION)
        else:
            sine = math.sin(value / 2.0)
            turned = (x * sine, y * sine, z * sine, math.cos(value / 2.0))
            orientation = multiply(orientation, turned)
        if self._back is not None:
            back = self._back
            position, orientation = compose(position, orientation, back.position, back.orientation)
        return position, orientation
