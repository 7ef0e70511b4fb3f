"""<actor> of SDF -> the description of a person that moves by itself."""

from __future__ import annotations

from bullet_sim.description.actor import ActorMotion, Trajectory, person
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import ModelError
from bullet_sim.formats.joints import Version
from bullet_sim.formats.materials import Resolve
from bullet_sim.formats.sdf.model import parse_model_element
from bullet_sim.plugins import parse_plugin
from bullet_sim.plugins.xml import library
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import (
    Node,
    add_child,
    child_flag,
    child_number,
    child_text,
    copied,
    sdf_pose,
)

DEFAULT = "__default__"  # of an animation without a name: that of the skin's file
MOVERS = ("ActorPlugin", "PedestrianSFMPlugin")  # libraries of plugins of actors that are read
CYCLE = 1.1  # [s] of an animation, of which no file is read


def parse_actor(
    element: Node, label: str, resolve: Resolve, version: Version
) -> tuple[ModelDescription, Pose]:
    """The description of an <actor>, and where it stands before it begins: a person, or without a
    <skin> its <link>s.

    Of a person a trajectory with an animation that it does not have is left out, as in Gazebo.
    """
    name = element.get("name") or "actor"
    label = f"{label} actor '{name}'"
    pose = sdf_pose(element, label)
    skin = child_text(element, "skin/filename")
    if skin:
        element.warn(
            f"{label} is drawn as a person of simple shapes: skin '{skin}' and its animations are "
            "not read",
            "actors are drawn as persons of simple shapes; skins and animations are not read",
            f"'{name}'",
        )
    movers = [part for part in element.findall("plugin") if library(part) in MOVERS]
    for part in element:
        is_read = part in movers or (part.tag == "link" and not skin)
        if part.tag in ("plugin", "link", "joint") and not is_read:
            element.warn(
                f"{label} has a <{part.tag}> '{part.get('name')}', which is ignored",
                "actors have plugins, links or joints, which are ignored",
                f"<{part.tag}> of '{name}'",
            )
    motion = _motion(element, label, pose)
    if skin:
        model = person(name, motion)
        model.warnings = element.document.warnings
    else:
        model = parse_model_element(_links_of(element), resolve, version, _no_include)
        model.motion = motion
    for plugin in movers:
        parse_plugin(plugin, model)
    return model, pose


def _motion(element: Node, label: str, pose: Pose) -> ActorMotion:
    animations = {
        animation.get("name") or DEFAULT: child_flag(animation, "interpolate_x", label, False)
        for animation in element.findall("animation")
    }
    script = element.find("script")
    kinds = animations if animations or child_text(element, "skin/filename") else None
    return ActorMotion(
        trajectories=_trajectories(script, kinds, label),
        loop=True if script is None else child_flag(script, "loop", label, True),
        delay=0.0 if script is None else child_number(script, "delay_start", label, 0.0),
        starts=True if script is None else child_flag(script, "auto_start", label, True),
        by_distance=frozenset(name for name, is_so in animations.items() if is_so),
        pose=pose,
        scale=child_number(element, "skin/scale", label, 1.0) or 1.0,
    )


def _links_of(actor: Node) -> Node:
    """A <model> of the links of an actor, whose collisions touch nothing here; or an empty one."""
    model = copied(actor)
    model.tag = "model"
    for part in [part for part in model if part.tag != "link"]:
        model.remove(part)
    if not len(model):
        add_child(model, "link", "").set("name", f"{model.get('name')}_pose")
    return model


def _no_include(_: Node) -> tuple[Node, Version]:
    raise ModelError("actors include nothing")


def _trajectories(
    script: Node | None, animations: dict[str, bool] | None, label: str
) -> tuple[Trajectory, ...]:
    """By their ids; without any the first animation alone. No animations (None) lack none."""
    trajectories = []
    for element in [] if script is None else script.findall("trajectory"):
        animation = element.get("type") or DEFAULT
        if animations is not None and animation not in animations:
            element.warn(
                f"{label} has a trajectory of type '{animation}', animations are "
                f"{', '.join(animations) or '(none)'}; it is left out",
                "trajectories of actors have an animation that is not there and are left out",
                f"'{animation}'",
            )
            continue
        number = (element.get("id") or "0").strip()
        order = int(number) if number.lstrip("-").isdigit() else 0
        trajectories.append((order, _trajectory(element, animation, label)))
    if not trajectories and animations:
        return (Trajectory(next(iter(animations)), CYCLE),)
    return tuple(trajectory for _, trajectory in sorted(trajectories, key=lambda item: item[0]))


def _trajectory(element: Node, animation: str, label: str) -> Trajectory:
    points = {
        child_number(point, "time", f"{label} waypoint", 0.0): sdf_pose(point, f"{label} waypoint")
        for point in element.findall("waypoint")
    }
    if not points:
        return Trajectory(animation, CYCLE)
    times = sorted(points)
    poses = [points[time] for time in times]
    if times[0] != 0.0:
        times, poses = [0.0, *times], [poses[0], *poses]
    text = element.get("tension") or "0"
    try:
        tension = min(max(float(text), 0.0), 1.0)
    except ValueError:
        tension = 0.0
    return Trajectory(animation, times[-1], tuple(times), tuple(poses), tension)
