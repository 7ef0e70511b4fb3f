"""Joints that do what they are commanded, as those of the robots in C++ of ros_controllers' tests.

The tests of controllers start a robot without physics: its joints do what the controllers have
commanded after one period. Here such joints take the place of a model's, below the controllers, so
that everything above them is tested as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from bullet_bridge.plugins.base import ModelPlugin
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.description.model import Joint
from std_msgs.msg import Bool, Empty, Float64, Float64MultiArray
from std_srvs.srv import Empty as EmptyService
from std_srvs.srv import EmptyResponse

NAN = math.nan
PERIOD = 0.01  # [s] between two updates of the robots in C++


class KinematicJoints:
    """In place of a robot's Joints: the same methods.

    Args:
        limits: joint name -> its Joint of the description.
        start: first positions [rad, m] of the joints in that order; the others' are 0.
        clock: function that returns the simulated time [s].
        wrap: positions stay within half a turn of 0, and velocities are only followed as far as
            `lag` says.

    Attributes:
        lag: by joint: which fraction of the way to the command it does not make in a period.
        delayed: commands act one period later.
        upper: positions stop there [rad, m].
        running: False: all states are NaN.
    """

    def __init__(
        self,
        limits: Mapping[str, Joint],
        start: Sequence[float],
        wrap: bool,
        clock: Callable[[], float],
    ) -> None:
        self._clock, self._time = clock, clock()
        # those robots bound no velocities
        self.limits = {name: replace(joint, velocity=None) for name, joint in limits.items()}
        self.names, self._wrap = tuple(limits), wrap
        self._position = {**dict.fromkeys(self.names, 0.0), **dict(zip(self.names, start))}
        self._velocity = dict.fromkeys(self.names, 0.0)
        self._effort = dict.fromkeys(self.names, 0.0)
        self._commands: dict[str, tuple[str, float]] = {}
        self._last: dict[str, tuple[str, float]] = {}
        self.lag = dict.fromkeys(self.names, 0.0)
        self.delayed, self.upper, self.running = False, math.inf, True
        self._elapsed = 0.0  # since the last latch [s]
        self._is_new = False  # whether there are commands since then

    def read(self, handles: Iterable[JointHandle]) -> None:
        """As Joints.read."""
        self.advance()
        for name, handle in zip(self.names, handles):
            known = self.running
            handle.position = self._position[name] if known else NAN
            handle.velocity = self._velocity[name] if known else NAN

    def columns(self, indices: Sequence[int]) -> list[list[float]]:
        """As Joints.columns."""
        self.advance()
        names = [self.names[index] for index in indices]
        return [
            [values[name] if self.running else NAN for name in names]
            for values in (self._position, self._velocity, self._effort)
        ]

    def motor(self, name: str) -> KinematicMotor:
        """As Joints.motor."""
        return KinematicMotor(self, name)

    def apply_efforts(self, handles: Sequence[JointHandle]) -> None:
        """As Joints.apply_efforts, of unit inertias, within the URDF's limits of effort alone."""
        efforts = []
        for handle in handles:
            limit = handle.limits.effort or math.inf
            efforts.append((handle.name, min(max(handle.effort or 0.0, -limit), limit)))
        self.command("effort", efforts)

    def release(self, name: str) -> None:
        """It stops."""
        self._commands.pop(name, None)

    def command(self, interface: str, values: Iterable[tuple[str, float]]) -> None:
        self._commands.update({name: (interface, value) for name, value in values})
        self._is_new |= interface != "effort"  # efforts are written before every step

    def advance(self) -> None:
        """Move all joints until now; what moves them changes with new commands, or in a PERIOD."""
        period, self._time = self._clock() - self._time, self._clock()
        if period <= 0.0:  # not after a physics step
            return
        if self._is_new or self._elapsed >= PERIOD - 1e-9:
            self._elapsed, self._is_new = 0.0, False
            self._latch()
        self._elapsed += period
        if not self.running:
            return
        for name in self.names:
            position = self._position[name] + self._velocity[name] * period
            if position > self.upper:
                position, self._velocity[name] = self.upper, 0.0
            if self._wrap:
                position = math.remainder(position, 2.0 * math.pi)
            self._position[name] = position

    def _latch(self) -> None:
        """Let the commands act for the next PERIOD."""
        acting = self._last if self.delayed else self._commands
        self._last = dict(self._commands)
        for name in self.names:
            interface, value = acting.get(name, ("velocity", 0.0))
            share = 1.0 - self.lag[name]
            if interface == "position":
                self._velocity[name] = share * (value - self._position[name]) / PERIOD
            elif interface == "velocity":
                self._velocity[name] = (self.lag[name] if self._wrap else share) * value
            else:
                self._velocity[name] += value * PERIOD
                self._effort[name] = value


class KinematicMotor:
    """Motor of such a joint."""

    def __init__(self, joints: KinematicJoints, name: str) -> None:
        self._joints, self._name = joints, name

    def track_velocity(self, velocity: float, _effort: float) -> None:
        """As Motor's."""
        self._joints.command("velocity", [(self._name, velocity)])

    def track_position(self, position: float, _effort: float, _speed: float) -> None:
        """As Motor's."""
        self._joints.command("position", [(self._name, position)])

    def release(self) -> None:
        """As Motor's."""
        self._joints.release(self._name)


class KinematicRobot(ModelPlugin):
    """Puts KinematicJoints before a model's controllers.

    <interfaces>: hardware interfaces of every joint, with spaces between them; <start>: first
    positions; <wrap>: see KinematicJoints. Services start and stop; topics smoothing, smoothings,
    delay and upper_bound, each confirmed on parameter_updated.
    """

    every_step = True

    def configure(self, sdf: Any) -> None:
        if self.model.manager is None:
            raise ValueError("a kinematic robot needs the plugin libgazebo_ros_control.so")
        start = [float(text) for text in sdf.text("start").split()]
        limits = {name: self.model.joints.limits[name] for name in sorted(self.model.joints.names)}
        self._joints = joints = KinematicJoints(
            limits, start, sdf.flag("wrap", False), lambda: self.world.time
        )
        offered = dict.fromkeys(joints.names, tuple(sdf.text("interfaces").split()))
        hardware = self.model.manager.hardware
        self.call(lambda: hardware.put_before(joints, offered))
        self._confirmed = self.publisher("/parameter_updated", Empty)
        self._parameter("/smoothing", Float64, lambda data: self._set_lags([data] * len(limits)))
        self._parameter("/smoothings", Float64MultiArray, self._set_lags)
        self._parameter("/delay", Bool, lambda data: setattr(joints, "delayed", data))
        self._parameter("/upper_bound", Float64, lambda data: setattr(joints, "upper", data))
        for name, running in (("/start", True), ("/stop", False)):
            self.service(name, EmptyService, self._switch(running))

    def _switch(self, running: bool) -> Callable[[Any], EmptyResponse]:
        def handle(_request: Any) -> EmptyResponse:
            self.call(lambda: setattr(self._joints, "running", running))
            return EmptyResponse()

        return handle

    def _parameter(self, topic: str, message: type, change: Callable[[Any], None]) -> None:
        def on_message(received: Any) -> None:
            self.call(lambda: change(received.data))
            self._confirmed.publish(Empty())

        self.subscribe(topic, message, on_message)

    def _set_lags(self, values: Sequence[float]) -> None:
        self._joints.lag.update(zip(self._joints.names, values))

    def update(self, time: float, period: float) -> None:
        self._joints.advance()
