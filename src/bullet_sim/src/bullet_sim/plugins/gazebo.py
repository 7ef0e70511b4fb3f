"""Gazebo's own plugins that act without a command of its transport: specifications."""

from __future__ import annotations

from dataclasses import dataclass

from bullet_sim.plugins.drives import movable
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import Vec3


@dataclass(frozen=True)
class StandingWheelsSpec:
    """DiffDrivePlugin: wheels that stand, whatever turns them, as they do without a command."""

    name: str
    link: str
    joints: tuple[str, ...]
    topic: str = ""


@dataclass(frozen=True)
class InitialVelocitySpec:
    """InitialVelocityPlugin: a model's velocity when it is there, and after each reset.

    Attributes:
        linear, angular: (3,) [m/s], [rad/s], along the world's axes.
    """

    name: str
    link: str
    linear: Vec3
    angular: Vec3
    topic: str = ""


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
    return StandingWheelsSpec(xml.name or "diff_drive", xml.model.root, tuple(names))


@model_plugin("InitialVelocityPlugin")
def initial_velocity(xml: PluginXml) -> InitialVelocitySpec:
    return InitialVelocitySpec(
        xml.name or "initial_velocity",
        xml.model.root,
        xml.vector("linear"),
        xml.vector("angular"),
    )
