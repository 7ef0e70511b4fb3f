"""A harness, which lowers its model and lets it go, and the topics of a projector."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import rospy
from bullet_sim.component import Stateful
from bullet_sim.description.model import Joint
from bullet_sim.engine import WORLD as WORLD_LINK
from bullet_sim.plugins.harness import WORLD, HarnessSpec, ProjectorSpec, WinchGains
from std_msgs.msg import Bool, Float32, Int32, String

from bullet_bridge.plugins.base import ModelPlugin, PluginContext, Preparing, ros_side

STILL = 1e-6  # [rad/s, m/s] of a winch that is to hold its position


class WinchPid(Stateful):
    """Gazebo's PID, of the error of a state less its target."""

    STATE = ("state",)

    def __init__(self, gains: WinchGains) -> None:
        self._gains = gains
        self.state = (0.0, 0.0)  # integral term, last error

    def update(self, error: float, period: float) -> float:
        """The command; the rate of the first error is that of a change from 0, as there."""
        gains, (integral, last) = self._gains, self.state
        if not (period > 0.0 and math.isfinite(error)):
            return 0.0
        integral = _bounded(integral + gains.i * period * error, gains.i_min, gains.i_max)
        self.state = integral, error
        command = -gains.p * error - integral - gains.d * (error - last) / period
        return _bounded(command, gains.least, gains.most)


def _bounded(value: float, least: float, most: float) -> float:
    """A value within bounds, which count where they are in order."""
    return max(least, min(most, value)) if most >= least else value


@ros_side(HarnessSpec)
class HarnessPlugin(ModelPlugin):
    """Holds its model by joints, of which it drives one and lets one go.

    While its velocity is 0 the winch holds its position. It pulls alone by its velocity's gains,
    which never push. Numbers are in single precision, as there. Without a winch it lets go at once.
    """

    STATE = ("_target", "_held_at", "_is_held", "_positions", "_speeds", "_wanted", "_ends")
    CACHE = ("_joints",)
    COMMANDS = {
        "velocity_topic": (Float32, "_on_velocity"),
        "topic": (Bool, "_on_detach"),
    }
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._joints: list[Joint] = []

    def reset(self, time: float) -> None:
        """Held where the model is, by a winch that stands."""
        self._target = self._held_at = 0.0
        self._wanted: float | None = None  # velocity that the next update takes
        self._is_held, self._ends = True, False
        self._positions, self._speeds = WinchPid(self.spec.position), WinchPid(self.spec.velocity)
        self._joints = [self._in_body(joint) for joint in self.spec.joints]
        for joint in self._joints:
            self.model.change(self._key(joint), partial(self._attach, joint))
        super().reset(time)

    def _key(self, joint: Joint) -> tuple[str, str]:
        """Of the model's changes."""
        return "harness", joint.name

    def _attachment(self, joint: Joint) -> tuple[str, str, str]:
        """Key of the engine's."""
        return (self.model.name, *self._key(joint))

    def _in_body(self, joint: Joint) -> Joint:
        """A joint with its frame in that of the link of the engine that its child is in."""
        return replace(joint, anchor=self.model.link_in_body(joint.child)[1] * joint.anchor)

    def _attach(self, joint: Joint) -> None:
        number, part = self.model.body.number, self.model.link_in_body
        parent = WORLD_LINK if joint.parent == WORLD else (number, part(joint.parent)[0])
        child, key = (number, part(joint.child)[0]), self._attachment(joint)
        if not self.world.engine.attach_by_joint(key, parent, child, joint):
            rospy.logwarn_once("the solver 'bullet' has no joints of a HarnessPlugin")

    def _remove(self, joint: Joint) -> None:
        self.world.engine.detach(self._attachment(joint))

    def _on_velocity(self, message: Any) -> None:
        value = float(message.data)
        if not self._is_held or self.spec.winch < 0:
            rospy.logerr("No known winch joint to set velocity")
        elif not math.isfinite(value):
            rospy.logerr("%s is %g, must be a finite number", self.spec.velocity_topic, value)
        else:
            self._wanted = value

    def _lower(self, velocity: float) -> None:
        """Have the winch move at a velocity, or hold where it is."""
        self._target = float(np.float32(velocity))
        if abs(self._target) <= STILL:
            self._held_at = float(np.float32(self._winch()[0]))
            self._positions.state = (0.0, 0.0)

    def _on_detach(self, message: Any) -> None:
        if message.data:
            self._ends = True

    def _let_go(self) -> None:
        """Remove the joint that is to be detached; the others stay, and nothing is driven."""
        if not self._is_held or self.spec.detach < 0:
            rospy.logerr("No known joint to detach")
            return
        self._is_held = False
        joint = self._joints[self.spec.detach]
        self.model.change(self._key(joint), partial(self._remove, joint))

    def _winch(self) -> tuple[float, float]:
        """Position and velocity of the winch."""
        key = self._attachment(self._joints[self.spec.winch])
        return self.world.engine.attached_state(key)

    def update(self, time: float, period: float) -> None:
        if self._wanted is not None:
            self._lower(self._wanted)
            self._wanted = None
        if self._ends or (self._is_held and self.spec.winch < 0 <= self.spec.detach):
            self._let_go()
            self._ends = False
        if not self._is_held or self.spec.winch < 0:
            return
        joint, step = self._joints[self.spec.winch], self.world.time_step
        position, speed = self._winch()
        error = position - self._held_at if abs(self._target) <= STILL else 0.0
        effort = self._positions.update(error, step)
        effort += max(0.0, self._speeds.update(speed - self._target, step))
        if joint.velocity >= 0.0 and abs(speed) > joint.velocity and speed * effort > 0.0:
            effort = 0.0
        if joint.effort >= 0.0:
            effort = max(-joint.effort, min(joint.effort, effort))
        self.world.engine.add_attached_effort(self._attachment(joint), effort)

    def close(self) -> None:
        """Let go of everything."""
        super().close()
        for joint in self._joints:
            self._remove(joint)


@ros_side(ProjectorSpec)
class ProjectorPlugin(Preparing):
    """Subscribes to what would choose a projector's texture and switch it; nothing is projected."""

    COMMANDS = {"topic": (String, "_ignore"), "switch_topic": (Int32, "_ignore")}

    def _ignore(self, _message: Any) -> None:
        """Nothing is projected."""
