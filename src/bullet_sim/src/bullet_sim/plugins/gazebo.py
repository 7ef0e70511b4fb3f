"""Gazebo's own plugins that act without a command of its transport."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from bullet_sim.parts.base import Acting, Part, Preparing, part_of
from bullet_sim.plugins.joints import movable
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, link_of, number, read, reading, switch, vector
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import Array, Vec3


@dataclass(frozen=True)
class StandingWheelsSpec(PluginSpec):
    """DiffDrivePlugin: wheels that stand, whatever turns them, as they do without a command."""

    NAME = "diff_drive"
    joints: tuple[str, ...]
    topic: str = ""


@model_plugin("InitialVelocityPlugin")
@dataclass(frozen=True)
class InitialVelocitySpec(PluginSpec):
    """InitialVelocityPlugin: a model's velocity when it is there, and after each reset.

    Attributes:
        linear, angular: (3,) [m/s], [rad/s], along the world's axes.
    """

    NAME = "initial_velocity"
    linear: Vec3 = vector("linear")
    angular: Vec3 = vector("angular")
    topic: str = ""


def _bounds(axis: str) -> Any:
    """The smaller and the larger of <min_AXIS> and <max_AXIS>; without one no bound."""

    def of(xml: PluginXml) -> tuple[float, float]:
        low, high = xml.number(f"min_{axis}", -math.inf), xml.number(f"max_{axis}", math.inf)
        return min(low, high), max(low, high)

    return reading(of, (-math.inf, math.inf))


@model_plugin("RandomVelocityPlugin")
@dataclass(frozen=True)
class RandomVelocitySpec(PluginSpec):
    """RandomVelocityPlugin: a link's velocity in each step, from time to time another one.

    Attributes:
        link: whose center of mass has it.
        first: until the first period is over [m/s], along the world's axes.
        speed: of the others, in a random direction [m/s].
        period: after which another one is drawn [s].
        x, y, z: bounds of what is drawn [m/s].
    """

    NAME = "random_velocity"
    link: str = link_of("link")
    first: Vec3 = vector("initial_velocity")
    speed: float = number("velocity_factor", 1.0)
    period: float = number("update_period", 10.0)
    x: tuple[float, float] = _bounds("x")
    y: tuple[float, float] = _bounds("y")
    z: tuple[float, float] = _bounds("z")
    topic: str = ""


SLOW = 0.01  # [m/s] below which a wing has no lift
RIGHT_ANGLE = 0.5 * math.pi


def _unit(values: Array) -> Array:
    """A values of length 1; one without a length stays."""
    length = float(np.linalg.norm(values))
    return values / length if length > 0.0 else values


def _direction(tag: str, default: Vec3) -> Any:
    """A vector of length 1."""

    def of(xml: PluginXml) -> Vec3:
        x, y, z = _unit(np.array(xml.vector(tag, default=default))).tolist()
        return x, y, z

    return reading(of, default)


def _control_joint(xml: PluginXml) -> str:
    """The joint whose angle adds to the lift; one that the model lacks adds nothing."""
    joint = xml.in_scope(xml.text("control_joint_name"))
    if not joint or joint in xml.model.joints:
        return joint
    xml.warn(f"{xml.label} has control_joint_name '{joint}', which is no joint; it has none")
    return ""


@model_plugin("LiftDragPlugin")
@dataclass(frozen=True)
class LiftDragSpec(PluginSpec):
    """LiftDragPlugin: lift and drag of a wing that is a link.

    Attributes:
        a0: angle of attack of the link's own direction [rad].
        cla, cda: lift and drag over the angle of attack [1/rad].
        alpha_stall: angle at which it stalls [rad]; cla_stall, cda_stall: as cla, cda from then on.
        cp: center of pressure in the link's frame [m].
        forward, upward: (3,) unit vectors in the link's frame.
        area: [m^2]; density: of the air [kg/m^3].
        radial: what is up depends on the air's direction alone, as of a body of revolution.
        joint: whose angle adds to the lift, `gain` [1/rad]; empty: none.
    """

    NAME = "lift_drag"
    link: str = link_of("link_name")
    a0: float = number("a0")
    cla: float = number("cla", 1.0)
    cda: float = number("cda", 0.01)
    alpha_stall: float = number("alpha_stall", RIGHT_ANGLE)
    cla_stall: float = number("cla_stall")
    cda_stall: float = number("cda_stall", 1.0)
    cp: Vec3 = vector("cp")
    forward: Vec3 = _direction("forward", (1.0, 0.0, 0.0))
    upward: Vec3 = _direction("upward", (0.0, 0.0, 1.0))
    area: float = number("area", 1.0)
    density: float = number("air_density", 1.2041)
    radial: bool = switch("radial_symmetry")
    joint: str = reading(_control_joint, "")
    gain: float = number("control_joint_rad_to_cl", 4.0)
    topic: str = ""

    def force(self, rotation: Array, velocity: Array, angle: float = 0.0) -> Array:
        """Lift and drag (3,) [N], world axes, as Gazebo 11's plugin computes them.

        Args:
            rotation: (3, 3) of the link.
            velocity: (3,) of the center of pressure, which is that of the air past it [m/s].
            angle: of `joint` [rad].
        """
        speed = float(np.linalg.norm(velocity))
        if speed <= SLOW:
            return np.zeros(3)
        ahead, along = rotation @ np.array(self.forward), velocity / speed
        if self.radial:
            up = _unit(np.cross(ahead, np.cross(ahead, along)))
        else:
            up = rotation @ np.array(self.upward)
        span = _unit(np.cross(ahead, up))
        sideways = min(max(float(span @ along), -1.0), 1.0)
        sweep = 1.0 - sideways**2  # the cosine's square, which Gazebo takes for the cosine
        across = velocity - float(velocity @ span) * along
        lift_axis, drag_axis = _unit(np.cross(span, across)), -_unit(across)
        attack = math.acos(min(max(float(lift_axis @ up), -1.0), 1.0))
        attack = self.a0 + math.copysign(attack, 1.0 if lift_axis @ ahead >= 0.0 else -1.0)
        while abs(attack) > RIGHT_ANGLE:
            attack -= math.copysign(math.pi, attack)
        lift = _stalling(attack, self.cla, self.cla_stall, self.alpha_stall) * sweep
        if abs(attack) > self.alpha_stall:  # it keeps its sign
            lift = max(0.0, lift) if attack > 0.0 else min(0.0, lift)
        lift += self.gain * angle
        drag = abs(_stalling(attack, self.cda, self.cda_stall, self.alpha_stall) * sweep)
        pressure = 0.5 * self.density * float(across @ across) * self.area
        result: Array = pressure * (lift * lift_axis + drag * drag_axis)
        return result


def _stalling(attack: float, slope: float, stalled: float, limit: float) -> float:
    """A coefficient at an angle of attack [rad], with another slope beyond a limit."""
    if abs(attack) <= limit:
        return slope * attack
    return math.copysign(slope * limit, attack) + stalled * (attack - math.copysign(limit, attack))


@model_plugin("DiffDrivePlugin")
def standing_wheels(xml: PluginXml) -> StandingWheelsSpec | None:
    """StandingWheelsSpec; commands come by Gazebo's own transport alone."""
    names = [xml.in_scope(xml.text(f"{side}_joint")) for side in ("left", "right")]
    if len(movable(xml, names)) < 2:
        return None
    xml.warn(
        f"{xml.label} gets no commands: they come by Gazebo's own transport; its wheels stand",
        "plugins get no commands, which come by Gazebo's own transport",
        xml.label,
    )
    return read(StandingWheelsSpec, xml, joints=tuple(names))


NANO = 1e-9  # [s] by which times may be off


@part_of(StandingWheelsSpec)
class StandingWheelsPlugin(Preparing):
    """Gives wheels a velocity of 0 before each step."""

    def prepare(self) -> None:
        """From now on (simulation thread)."""
        self.model.joints.impose_velocities(self.spec.joints, [0.0] * len(self.spec.joints))


@part_of(InitialVelocitySpec)
class InitialVelocityPlugin(Preparing):
    """Gives its model a velocity."""

    def prepare(self) -> None:
        """Now (simulation thread)."""
        self.model.set_velocity(self.spec.linear, self.spec.angular)


@part_of(RandomVelocitySpec)
class RandomVelocityPlugin(Part):
    """Gives a link a velocity before each step."""

    STATE = ("_velocity", "_drawn")
    every_step = True

    def start(self, time: float) -> None:
        """As Reset() of Gazebo's, which keeps the velocity and counts periods from time 0."""
        self._velocity: Vec3 = getattr(self, "_velocity", self.spec.first)
        self._drawn = 0.0

    def prepare(self) -> None:
        """Before the first step (simulation thread)."""
        self.update(self.world.time, 0.0)

    def update(self, time: float, period: float) -> None:
        spec, now = self.spec, time + self.world.time_step
        if now - self._drawn > spec.period + NANO:
            drawn = self.rng.uniform(-1.0, 1.0, 3)
            drawn *= spec.speed / (np.linalg.norm(drawn) or 1.0)
            x, y, z = (
                float(min(max(value, low), high))
                for value, (low, high) in zip(drawn, (spec.x, spec.y, spec.z))
            )
            self._velocity, self._drawn = (x, y, z), now
        if not self.model.is_static:
            part, _ = self.model.link_in_body(spec.link)
            self.model.body.set_link_velocity(part, self._velocity)


@part_of(LiftDragSpec)
class LiftDragPlugin(Acting):
    """Applies lift and drag to a link in every step.

    As in Gazebo the velocity is that of the center of pressure in the link's frame, and the force
    acts as far from the center of mass as that is from the frame.
    """

    def update(self, time: float, period: float) -> None:
        spec, model = self.spec, self.model
        if model.is_static:
            return
        pose, linear, angular = model.link_state(spec.link)
        rotation = pose.matrix
        arm = rotation @ np.array(spec.cp)
        angle = model.joints.state()[0].get(spec.joint, 0.0) if spec.joint else 0.0
        force = spec.force(rotation, linear + np.cross(angular, arm), angle)
        if force.any():
            part, _ = model.link_in_body(spec.link)
            model.body.apply_force(part, force, model.body.link_center(part) + arm)
