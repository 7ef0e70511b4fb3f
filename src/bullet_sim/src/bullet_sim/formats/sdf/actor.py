"""<actor> of SDF -> the description of a person that moves by itself."""

from __future__ import annotations

from bullet_sim.description.actor import ActorMotion, Trajectory, person
from bullet_sim.description.model import ModelDescription
from bullet_sim.plugins import parse_plugin
from bullet_sim.plugins.xml import library
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import Node, child_flag, child_number, child_text, sdf_pose

DEFAULT = "__default__"  # of an animation without a name: that of the skin's file
MOVERS = ("ActorPlugin", "PedestrianSFMPlugin")  # libraries of plugins of actors that are read
CYCLE = 1.1  # [s] of an animation, of which no file is read


def parse_actor(element: Node, label: str) -> tuple[ModelDescription, Pose]:
    """The description of an <actor>, and where it stands before it begins.

    A trajectory with an animation that the actor does not have is left out, as in Gazebo.
    """
    name = element.get("name") or "actor"
    label = f"{label} actor '{name}'"
    pose = sdf_pose(element, label)
    skin = child_text(element, "skin/filename") or "(none)"
    element.warn(
        f"{label} is drawn as a person of simple shapes: skin '{skin}' and its animations are "
        "not read",
        "actors are drawn as persons of simple shapes; skins and animations are not read",
        f"'{name}'",
    )
    movers = [part for part in element.findall("plugin") if library(part) in MOVERS]
    for tag in ("plugin", "link", "joint"):
        for part in element.findall(tag):
            if part in movers:
                continue
            element.warn(
                f"{label} has a <{tag}> '{part.get('name')}', which is ignored",
                "actors have plugins, links or joints, which are ignored",
                f"<{tag}> of '{name}'",
            )
    animations = {
        animation.get("name") or DEFAULT: child_flag(animation, "interpolate_x", label, False)
        for animation in element.findall("animation")
    }
    script = element.find("script")
    motion = ActorMotion(
        trajectories=_trajectories(script, animations, label),
        loop=True if script is None else child_flag(script, "loop", label, True),
        delay=0.0 if script is None else child_number(script, "delay_start", label, 0.0),
        starts=True if script is None else child_flag(script, "auto_start", label, True),
        by_distance=frozenset(name for name, is_so in animations.items() if is_so),
        pose=pose,
        scale=child_number(element, "skin/scale", label, 1.0) or 1.0,
    )
    model = person(name, motion)
    model.warnings = element.document.warnings
    for plugin in movers:
        parse_plugin(plugin, model)
    return model, pose


def _trajectories(
    script: Node | None, animations: dict[str, bool], label: str
) -> tuple[Trajectory, ...]:
    """By their ids; without any the first animation alone."""
    trajectories = []
    for element in [] if script is None else script.findall("trajectory"):
        animation = element.get("type") or DEFAULT
        if animation not in animations:
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
