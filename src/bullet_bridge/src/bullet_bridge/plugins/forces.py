"""Forces on links: a wrench by topic, a vacuum gripper."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import rospy
from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.plugins.forces import ForceSpec, VacuumGripperSpec, WheelSlipSpec
from bullet_sim.pose import Pose
from geometry_msgs.msg import Wrench
from paddock_common.reconfigure import describe
from std_msgs.msg import Bool
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
    links only the root link is drawn.
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
                    found |= not model.is_static and self._draw(model, pose, linear, angular)
        if self._grasping.get_num_connections() > 0:
            self._grasping.publish(Bool(found))

    @staticmethod
    def _draw(model: Any, pose: Pose, linear: Any, angular: Any) -> bool:
        """Draw a model's root link to a pose; returns whether it is near enough."""
        root = model.description.root
        own = model.link_state(root)[0]
        away = np.array((own.inverse() * pose).position)
        distance = float(np.linalg.norm(away))
        if distance >= REACH:
            return False
        if distance < NEAR:
            model.set_state(Pose(pose.position, own.orientation), linear, angular)
        else:
            model.engine.set_velocity(model.body, linear, angular)
        if distance > 0.0:
            pull = min(1.0 / distance, MAX_PULL) * away / distance
            model.apply_wrench(model.index(root), pull, np.zeros(3))
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
