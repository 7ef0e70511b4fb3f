"""Forces on links, applied and measured: wrenches, a vacuum gripper, slip, a fluid, a lift."""

from __future__ import annotations

import math
import re
from functools import partial
from typing import Any

import numpy as np
import rospy
from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.meshes.triangles import mesh_box
from bullet_sim.plugins import forces as specs
from bullet_sim.pose import Pose, Vector
from bullet_sim.sensors.inertial import joint_wrench, net_wrench
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from paddock_common.reconfigure import describe
from std_msgs.msg import Bool, String
from std_srvs.srv import Empty, EmptyResponse
from tf2_msgs.msg import TFMessage

from bullet_bridge.plugins.base import (
    ModelPlugin,
    PluginContext,
    Sensor,
    has_subscribers,
    ros_side,
)
from bullet_bridge.transport import conversions
from bullet_bridge.transport.conversions import vector


@ros_side(specs.ForceSpec)
class ForcePlugin(ModelPlugin):
    """Applies the last geometry_msgs/Wrench to a link in every step, along the world's axes."""

    STATE = ("_wrench",)
    COMMANDS = {"topic": (Wrench, "_on_wrench")}
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._part, _ = self.model.link_in_body(self.spec.link)

    def reset(self, time: float) -> None:
        """Without a wrench."""
        self._wrench = (np.zeros(3), np.zeros(3))
        super().reset(time)

    def _on_wrench(self, message: Any) -> None:
        wrench = vector(message.force), vector(message.torque)
        if not np.abs(wrench).max() <= MAX_COMMAND:  # also of NaN
            rospy.logerr_throttle(
                1.0,
                f"{self.spec.topic}: wrench {[*wrench[0], *wrench[1]]}, must be finite numbers, at "
                f"most {MAX_COMMAND:g} either way; the last valid one is kept",
            )
            return
        self._wrench = wrench

    def update(self, time: float, period: float) -> None:
        force, torque = self._wrench
        if force.any() or torque.any():
            self.model.apply_wrench(self._part, force, torque)


REACH = 0.05  # [m] between the origins of two links, below which the gripper draws
NEAR = 0.01  # [m] below which it holds the other's origin at its own
MAX_PULL = 20.0  # [N]


@ros_side(specs.VacuumGripperSpec)
class VacuumGripperPlugin(ModelPlugin):
    """Draws links of other models that are near its link; std_msgs/Bool tells whether there is one.

    While it is on, such a link gets the gripper's velocity and a force towards it. As upstream the
    force is computed along the other link's axes and acts along the world's. Of models with several
    links only the root link gets the velocity.
    """

    STATE = ("_is_on",)
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        namespace = self.spec.namespace
        self._is_on = False
        self._grasping = self.publisher(self.spec.topic, Bool)
        for name, is_on in (("on", True), ("off", False)):
            self.service(f"{namespace}/{name}", Empty, partial(self._switch, is_on))

    def _switch(self, is_on: bool, _request: Any) -> Any:
        if self._is_on == is_on:
            word = "on" if is_on else "off"
            rospy.logwarn("gazebo_ros_vacuum_gripper: already status is '%s'", word)
        self._is_on = is_on
        return EmptyResponse()

    def update(self, time: float, period: float) -> None:
        draws = False
        if self._is_on:
            pose, linear, angular = self.model.link_state(self.spec.link)
            for model in self.world.models.values():
                if model is not self.model and model.name != self.spec.link:
                    for link in model.rigid_parts:
                        draws |= self._draw(model, link, pose, linear, angular)
        if has_subscribers(self._grasping):
            self._grasping.publish(Bool(draws))

    @staticmethod
    def _draw(model: Any, link: str, pose: Pose, linear: Any, angular: Any) -> bool:
        """Draw a model's link to a pose; returns whether it is near enough, static or not."""
        own = model.link_state(link)[0]
        away = np.array((own.inverse() * pose).position)
        distance = float(np.linalg.norm(away))
        if distance >= REACH:
            return False
        if model.is_static:
            return True
        if link != model.description.root:
            pass
        elif distance < NEAR:
            there = Pose(pose.position, own.orientation) * model.description.root_pose.inverse()
            model.set_state(there, linear, angular)
        else:
            model.body.set_velocity(linear, angular)
        if distance > 0.0:
            pull = min(1.0 / distance, MAX_PULL) * away / distance
            model.apply_wrench(model.link_in_body(link)[0], pull, np.zeros(3))
        return True


# As gazebo_plugins' cfg/WheelSlip.cfg: what is below 0 changes nothing.
_SLIP = describe(
    tuple(
        (
            f"slip_compliance_unitless_{side}",
            "double",
            -1.0,
            -1.0,
            20.0,
            f"Unitless slip compliance (slip over friction), {side}.",
        )
        for side in ("lateral", "longitudinal")
    )
)


@ros_side(specs.WheelSlipSpec)
class WheelSlipPlugin(ModelPlugin):
    """Sets slip1 and slip2 of wheels' contacts: their rims' speed times compliance over force."""

    STATE = ("_lateral", "_longitudinal")
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        wheels, model = self.spec.wheels, self.model
        self._lateral = [wheel.lateral for wheel in wheels]
        self._longitudinal = [wheel.longitudinal for wheel in wheels]
        self._links = [model.link_in_body(wheel.link)[0] for wheel in wheels]
        if self.spec.namespace:
            self.reconfigure(self.spec.namespace, _SLIP, dict(_SLIP.defaults), self._on_values)

    def _on_values(self, config: Any, _level: int) -> Any:
        lateral, longitudinal = (config[name] for name in sorted(_SLIP.defaults))
        self.call(lambda: self._set(lateral, longitudinal))
        return config

    def _set(self, lateral: float, longitudinal: float) -> None:
        """New compliances of all wheels; below 0: as they are."""
        count = len(self.spec.wheels)
        if lateral >= 0.0:
            self._lateral = [lateral] * count
        if longitudinal >= 0.0:
            self._longitudinal = [longitudinal] * count

    def update(self, time: float, period: float) -> None:
        model = self.model
        for number, wheel in enumerate(self.spec.wheels):
            joint = model.description.joints[wheel.joint]
            pose, _, angular = model.link_state(wheel.link)
            axis = pose.matrix @ np.asarray(joint.axis) / np.linalg.norm(joint.axis)
            scale = wheel.radius * abs(float(angular @ axis)) / wheel.force
            slips = scale * self._lateral[number], scale * self._longitudinal[number]
            model.body.set_slip(self._links[number], *slips)


@ros_side(specs.BuoyancySpec)
class BuoyancyPlugin(ModelPlugin):
    """Lifts each link by the weight of the fluid that it displaces, wherever it is, as Gazebo's."""

    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        given = {part.link: part for part in self.spec.given}
        parts = self.model.rigid_parts.items()
        self._parts = [given.get(name) or self._displaced(name, link) for name, link in parts]

    def _displaced(self, name: str, link: Any) -> specs.Floating:
        """The volume of a link's collisions, of a mesh that of the box around it."""
        volumes, places = [0.0], [np.zeros(3)]
        for shape in link.collisions:
            kind, size = shape.geometry.kind, shape.geometry.size
            if kind == "box":
                volume = float(np.prod(size))
            elif kind == "sphere":
                volume = 4.0 / 3.0 * math.pi * size[0] ** 3
            elif kind == "cylinder":
                volume = math.pi * size[0] ** 2 * size[1]
            elif kind == "mesh":
                low, high = mesh_box(shape.geometry.path)
                volume = float(np.prod((high - low) * np.abs(shape.geometry.scale)))
            else:
                continue
            volumes.append(volume)
            places.append(np.array(shape.pose.position))
        total = sum(volumes)
        middle = np.average(places, axis=0, weights=volumes) if total else np.zeros(3)
        x, y, z = middle.tolist()
        return specs.Floating(name, total, (x, y, z))

    def update(self, time: float, period: float) -> None:
        if self.model.is_static:
            return
        for part in self._parts:
            link, offset = self.model.link_in_body(part.link)
            frame = Pose(*self.model.body.link_motion(link)[:2]) * offset
            point = (frame * Pose(part.center)).position
            force = [-self.spec.density * part.volume * axis for axis in self.world.gravity]
            self.model.body.apply_force(link, force, point)


@ros_side(specs.HandOfGodSpec)
class HandOfGodPlugin(ModelPlugin):
    """Pulls a link to the frame FRAME_desired by a critically damped spring; sends FRAME_actual."""

    CACHE = ("_missing",)  # whether it was logged
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec, model = self.spec, self.model
        self._part, _ = model.link_in_body(spec.link)
        part = model.rigid_parts[self._part]
        self._damping = (
            2.0 * math.sqrt(spec.linear * part.mass),
            2.0 * math.sqrt(spec.angular * part.inertia[0, 0]),
        )
        self._missing = False
        self._actual = self.publisher(spec.topic, TFMessage)
        self._buffer = self.transforms()

    def _desired(self) -> Pose | None:
        """Pose to pull to, or None, logged once."""
        from tf2_ros import TransformException

        try:
            transform = self._buffer.lookup_transform(
                "world", f"{self.spec.frame}_desired", rospy.Time(0)
            ).transform
        except TransformException as error:
            if not self._missing:
                rospy.logerr("hand of god: %s", error)
            self._missing = True
            return None
        self._missing = False
        p, q = transform.translation, transform.rotation
        return Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))

    def update(self, time: float, period: float) -> None:
        desired = self._desired()
        if desired is None:
            return
        pose, linear, angular = self.model.link_state(self.spec.link)
        away = np.subtract(desired.position, pose.position)
        x, y, z, w = (pose.inverse() * desired).orientation
        sign = -1.0 if w < 0.0 else 1.0
        sine = math.sqrt(x * x + y * y + z * z)
        half = math.atan2(sine, sign * w) / sine if sine > 1e-12 else 1.0
        rotation = sign * half * np.array((x, y, z))  # half the vector, as upstream takes it
        force = self.spec.linear * away - self._damping[0] * linear
        torque = pose.matrix @ (self.spec.angular * rotation) - self._damping[1] * angular
        self.model.apply_wrench(self._part, force, torque)
        if has_subscribers(self._actual):
            actual = f"{self.spec.frame}_actual"
            message = conversions.transform_to_msg(time, "world", actual, pose)
            self._actual.publish(TFMessage([message]))


CLOSED, OPEN = 0.0, 1.0  # positions of a lift's door
LIFT_GAINS, DOOR_GAINS = (1e5, 1e5), (2.0, 1.0)  # P, D
LIFT_NEAR, DOOR_NEAR = 0.15, 0.05  # errors at which they count as there


@ros_side(specs.ElevatorSpec)
class ElevatorPlugin(ModelPlugin):
    """Closes the door, goes to a floor, opens, waits and closes; meanwhile it takes no other floor.

    As upstream the derivative of the door's error is over the time since the start. It waits in
    simulated time.
    """

    STATE = ("_floor", "_door", "_steps", "_began", "_errors", "_there", "_until")
    COMMANDS = {"topic": (String, "_on_floor")}
    every_step = True

    def reset(self, time: float) -> None:
        """As it was loaded, but for where it goes and whether its door is to be open."""
        self._floor: int = getattr(self, "_floor", 0)
        self._door: float = getattr(self, "_door", CLOSED)
        self._steps: tuple[tuple[str, int], ...] = ()  # that are to be made, each with a floor
        self._began = self._until = math.nan
        self._errors, self._there = (0.0, 0.0), (True, True)  # of the lift and the door
        super().reset(time)

    def _on_floor(self, message: Any) -> None:
        number = re.match(r"\s*([+-]?0*\d{1,10})(?!\d)", message.data)  # as C++ reads one
        floor = int(number[1]) if number else 1 << 31
        if not -(1 << 31) <= floor < 1 << 31:
            rospy.logerr("%s: '%.80s' is no number of a floor", self.spec.topic, message.data)
            return
        if not self._steps:
            steps = ("close", "move", "open", "wait", "close")
            self._steps = tuple((step, floor) for step in steps)
            self._until = math.nan

    def update(self, time: float, period: float) -> None:
        if self._steps and self._is_done(time, *self._steps[0]):
            self._steps, self._until = self._steps[1:], math.nan
        if math.isnan(self._began):
            self._began = time
            return
        positions = self.model.joints.state()[0]
        lift = positions[self.spec.lift] - self._floor * self.spec.height
        door = positions[self.spec.door] - self._door
        step = self.world.time_step
        for joint, error, old, gains, elapsed in (
            (self.spec.lift, lift, self._errors[0], LIFT_GAINS, step),
            (self.spec.door, door, self._errors[1], DOOR_GAINS, time - self._began),
        ):
            effort = -gains[0] * error - gains[1] * (error - old) / elapsed
            self.model.joints.add_effort(joint, effort)
        self._errors = lift, door
        self._there = abs(lift) < LIFT_NEAR, abs(door) < DOOR_NEAR

    def _is_done(self, time: float, step: str, floor: int) -> bool:
        """Begin a step, or tell whether it is made."""
        if math.isnan(self._until):
            self._until = time + (self.spec.wait if step == "wait" else 0.0)
            if step == "move":
                self._floor = floor
            elif step != "wait":
                self._door = OPEN if step == "open" else CLOSED
            return False
        if step == "wait":
            return time >= self._until
        return self._there[0 if step == "move" else 1]


def wrench_message(time: float, frame: str, force: Vector, torque: Vector) -> WrenchStamped:
    """geometry_msgs/WrenchStamped of two (3,) [N, N m]."""
    message = WrenchStamped(header=conversions.header(time, frame))
    message.wrench.force = Vector3(*map(float, force))
    message.wrench.torque = Vector3(*map(float, torque))
    return message


@ros_side(specs.ForceTorqueSpec)
class ForceTorqueSensor(Sensor):
    """geometry_msgs/WrenchStamped of a joint: its child link on its parent, child's axes.

    Zeros of a joint without <provide_feedback>.
    """

    message = WrenchStamped
    whole_periods = True
    waits_for_time = True

    def measure(self, time: float) -> WrenchStamped:
        wrench: Any = (np.zeros(3), np.zeros(3))
        if self.spec.feedback:
            wrench = joint_wrench(self.model, self.spec.joint)
        if self.spec.noise_stddev:
            wrench = [v + self.rng.normal(0.0, self.spec.noise_stddev, 3) for v in wrench]
        return wrench_message(time, self.spec.frame_id, *wrench)


@ros_side(specs.LinkForceSpec)
class LinkForceSensor(Sensor):
    """geometry_msgs/WrenchStamped of the net force on a link, mean over a step, world axes."""

    STATE = ("_before",)
    message = WrenchStamped

    def start(self, time: float) -> None:
        """Measure from now on."""
        self._before: Any = None  # (velocity, angular velocity, time) at the last measurement

    def measure(self, time: float) -> WrenchStamped | None:
        part = self.model.description.links[self.spec.link]
        pose, linear, angular = self.model.link_state(self.spec.link)
        speed = linear + np.cross(angular, pose.matrix @ part.center)
        before, self._before = self._before, (speed, angular, time)
        if before is None or not time > before[2]:
            return None
        inertia = pose.matrix @ part.inertia @ pose.matrix.T
        wrench = net_wrench(part.mass, inertia, before[:2], (speed, angular), time - before[2])
        return wrench_message(time, self.spec.frame_id, *wrench)
