"""Forces on links: a wrench by topic, a vacuum gripper, slip, a fluid, a lift."""

from __future__ import annotations

import math
import re
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import rospy
from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.plugins.forces import (
    BuoyancySpec,
    ElevatorSpec,
    Floating,
    ForceSpec,
    VacuumGripperSpec,
    WheelSlipSpec,
)
from bullet_sim.pose import Pose
from geometry_msgs.msg import Wrench
from paddock_common.reconfigure import describe
from std_msgs.msg import Bool, String
from std_srvs.srv import Empty, EmptyResponse

from bullet_bridge.plugins.base import ModelPlugin, PluginContext, ros_side
from bullet_bridge.transport.conversions import vector


@ros_side(ForceSpec)
class ForcePlugin(ModelPlugin):
    """Applies the last geometry_msgs/Wrench to a link in every step, along the world's axes."""

    STATE = ("_wrench",)
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._index, _ = self.model.link_in_body(self.spec.link)

    def listen(self) -> None:
        """Subscribe to the wrenches."""
        self.subscribe(self.spec.topic, Wrench, self._on_wrench)

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
            self.model.apply_wrench(self._index, force, torque)


REACH = 0.05  # [m] between the origins of two links, below which the gripper draws
NEAR = 0.01  # [m] below which it holds the other's origin at its own
MAX_PULL = 20.0  # [N]


@ros_side(VacuumGripperSpec)
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
        found = False
        if self._is_on:
            pose, linear, angular = self.model.link_state(self.spec.link)
            for model in self.world.models.values():
                if model is not self.model and model.name != self.spec.link:
                    for link in model.rigid_parts:
                        found |= self._draw(model, link, pose, linear, angular)
        if self._grasping.get_num_connections() > 0:
            self._grasping.publish(Bool(found))

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
            model.engine.set_velocity(model.body, linear, angular)
        if distance > 0.0:
            pull = min(1.0 / distance, MAX_PULL) * away / distance
            model.apply_wrench(model.index(link), pull, np.zeros(3))
        return True


# As gazebo_plugins' cfg/WheelSlip.cfg: what is below 0 changes nothing.
_SLIP = SimpleNamespace(
    **describe(
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
)


@ros_side(WheelSlipSpec)
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
            model.engine.set_slip(model.body, self._links[number], *slips)


@ros_side(BuoyancySpec)
class BuoyancyPlugin(ModelPlugin):
    """Lifts each link by the weight of the fluid that it displaces, wherever it is, as Gazebo's."""

    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        given = {it.link: it for it in self.spec.given}
        parts = self.model.rigid_parts.items()
        self._parts = [given.get(name) or self._displaced(name, link) for name, link in parts]

    def _displaced(self, name: str, link: Any) -> Floating:
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
                low, high = self.world.engine.mesh_box(shape.geometry.path)
                volume = float(np.prod((high - low) * np.abs(shape.geometry.scale)))
            else:
                continue
            volumes.append(volume)
            places.append(np.array(shape.pose.position))
        total = sum(volumes)
        middle = np.average(places, axis=0, weights=volumes) if total else np.zeros(3)
        x, y, z = middle.tolist()
        return Floating(name, total, (x, y, z))

    def update(self, time: float, period: float) -> None:
        if self.model.is_static:
            return
        for part in self._parts:
            index, offset = self.model.link_in_body(part.link)
            frame = Pose(*self.model.frame_at(index)) * offset
            point = (frame * Pose(part.center)).position
            force = [-self.spec.density * part.volume * each for each in self.world.gravity]
            self.world.engine.apply_force(self.model.body, index, force, point)


CLOSED, OPEN = 0.0, 1.0  # positions of a lift's door
LIFT_GAINS, DOOR_GAINS = (1e5, 1e5), (2.0, 1.0)  # P, D
LIFT_NEAR, DOOR_NEAR = 0.15, 0.05  # errors at which they count as there


@ros_side(ElevatorSpec)
class ElevatorPlugin(ModelPlugin):
    """Closes the door, goes to a floor, opens, waits and closes; meanwhile it takes no other floor.

    As upstream the derivative of the door's error is over the time since the start. It waits in
    simulated time.
    """

    STATE = ("_floor", "_door", "_steps", "_began", "_errors", "_there", "_until")
    every_step = True

    def listen(self) -> None:
        """Subscribe to the floors."""
        self.subscribe(self.spec.topic, String, self._on_floor)

    def reset(self, time: float) -> None:
        """As it was loaded, but for where it goes and whether its door is to be open."""
        self._floor: int = getattr(self, "_floor", 0)
        self._door: float = getattr(self, "_door", CLOSED)
        self._steps: tuple[tuple[str, int], ...] = ()  # that are to be made, each with a floor
        self._began = self._until = math.nan
        self._errors, self._there = (0.0, 0.0), (True, True)  # of the lift and the door
        super().reset(time)

    def _on_floor(self, message: Any) -> None:
        number = re.match(r"\s*[+-]?\d+", message.data)  # as C++ reads one
        if number is None:
            rospy.logerr("%s: '%s' is no number of a floor", self.spec.topic, message.data)
            return
        floor = int(number.group())
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
