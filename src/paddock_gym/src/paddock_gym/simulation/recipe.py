"""What a world of robots is made of: a world file, models, their controllers; from plain files."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import xacro
import yaml
from bullet_sim.description.world import WorldDescription, empty_world
from bullet_sim.engine import FIXED_JOINTS
from bullet_sim.errors import SimError
from bullet_sim.files import read_file
from bullet_sim.formats.lumping import LEAVE_OUT
from bullet_sim.formats.resolve import FolderPackages, Resolver
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.pose import Pose

from paddock_gym.errors import GymError


@dataclass(frozen=True)
class Spawn:
    """A model that is spawned.

    Attributes:
        text: URDF or SDF.
        namespace: of its plugins, where they name none, and of its controllers.
        frame: model or link of the pose; empty: the world.
        joints: positions at the start [rad, m].
    """

    name: str
    text: str
    pose: Pose = Pose()
    namespace: str = ""
    frame: str = ""
    joints: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Recipe:
    """A world of robots.

    Attributes:
        world: path of a world file, as Gazebo takes it; empty: the empty world.
        described: a world that has been read, in place of `world`.
        spawns: models, in the order of spawning.
        controllers: (namespace, name) of those that are loaded and started.
        parameters: tree of the parameter server.
        remaps: resolved names of topics that have other names.
        seed: of all noise.
        massless_links, fixed_joints: see bullet_sim.world.World.
        left_out: nodes of a launch file that are not started, package/type each.
        resolve: finds files.
    """

    world: str = ""
    described: WorldDescription | None = None
    spawns: tuple[Spawn, ...] = ()
    controllers: tuple[tuple[str, str], ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    remaps: Mapping[str, str] = field(default_factory=dict)
    seed: int = 0
    massless_links: str = LEAVE_OUT
    fixed_joints: str = FIXED_JOINTS[0]
    left_out: tuple[str, ...] = ()
    resolve: Callable[[str], str] = field(default_factory=Resolver)

    def parameter(self, name: str) -> Any:
        """A parameter by its resolved name, or None."""
        value: Any = self.parameters
        for key in filter(None, name.split("/")):
            value = value.get(key) if isinstance(value, Mapping) else None
        return value

    def described_world(self) -> WorldDescription:
        """The world file's description.

        Raises:
            GymError: it cannot be read.
        """
        if self.described is not None or not self.world:
            return self.described or empty_world()
        try:
            path = self.resolve.world(self.world)
            text = read_file(path, "world file", "text_bytes")
            self.resolve.set_world(path)
            return parse_world(text, self.resolve, path)
        except ValueError as error:
            raise GymError(f"world is {self.world!r}: {error}") from error


def read_text(option: str, path: str, arguments: Mapping[str, str]) -> str:
    """Text of a model's file; a file that ends in .xacro is processed with the arguments.

    Raises:
        GymError: it cannot be read.
    """
    if not os.path.isfile(path):
        raise GymError(f"{option} is {path!r}: there is no such file")
    try:
        if path.endswith(".xacro"):
            made: str = xacro.process_file(path, mappings=dict(arguments)).toxml()
            return made
        text = read_file(path, option, "text_bytes")
    except (SimError, OSError) as error:
        raise GymError(f"{option} is {path!r}: {error}") from error
    except Exception as error:  # xacro has many
        raise GymError(f"{option} is {path!r}: xacro says: {error}") from error
    return text if isinstance(text, str) else text.decode("utf-8", "replace")


def from_files(
    urdf: str = "",
    sdf: str = "",
    world: str = "",
    controllers: str = "",
    pose: Sequence[float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    arguments: Mapping[str, str] | None = None,
) -> Recipe:
    """A world of plain files; without ROS.

    Args:
        urdf, sdf: path of the robot's file (.xacro: processed).
        world: path of a world file.
        controllers: path of a YAML file of ros_control's controllers, all of which run.
        pose: (x, y, z [m], roll, pitch, yaw [rad]) of the robot.
        arguments: of xacro.

    Raises:
        GymError: a file cannot be read.
    """
    if urdf and sdf:
        raise GymError("urdf and sdf are both given; a robot has one file, spawn others by launch=")
    spawns: list[Spawn] = []
    option, path = ("urdf", urdf) if urdf else ("sdf", sdf)
    if path:
        text = read_text(option, path, arguments or {})
        if len(tuple(pose)) != 6:
            raise GymError(f"pose is {pose!r}, must be six numbers: x, y, z, roll, pitch, yaw")
        x, y, z, *rpy = map(float, pose)
        spawns.append(Spawn("robot", text, Pose.from_xyz_rpy((x, y, z), tuple(rpy)), "/"))
    folders = [os.path.dirname(os.path.abspath(file)) for file in (path, world) if file]
    recipe = Recipe(world=world, spawns=tuple(spawns), resolve=Resolver(FolderPackages(folders)))
    return with_controllers(recipe, controllers) if controllers else recipe


def of_package(
    package: str, folder: str, world: str, time_step: float, robot: str, **arguments: str
) -> Recipe:
    """A robot of a package in one of its worlds; other packages need not be there.

    Args:
        folder: of the package's files.
        world: name of the world's file.
        time_step: physics step [s].
        robot: its name, and that of its xacro, which gets the arguments.
    """

    def resolve(uri: str) -> str:
        return uri.replace(f"package://{package}", folder).replace("file://", "")

    text = read_text("world", os.path.join(folder, "worlds", world), {})
    described = replace(parse_world(text, resolve), step=time_step)
    urdf = read_text("urdf", os.path.join(folder, "urdf", f"{robot}.urdf.xacro"), arguments)
    return Recipe(described=described, spawns=(Spawn(robot, urdf),), resolve=resolve)


def with_controllers(recipe: Recipe, path: str) -> Recipe:
    """The Recipe with the controllers of a YAML file, in their namespace if it has one."""
    try:
        with open(path, encoding="utf-8") as file:
            tree = yaml.safe_load(file)
    except (OSError, yaml.YAMLError) as error:
        raise GymError(f"controllers is {path!r}: {error}") from error
    found = list(_controllers_in("", tree)) if isinstance(tree, Mapping) else []
    if not found:
        raise GymError(f"controllers is {path!r}: no entry in it has a type, as controllers have")
    return replace(recipe, controllers=tuple(found), parameters=tree)


def _controllers_in(namespace: str, tree: Mapping[str, Any]) -> Any:
    for name, entry in tree.items():
        if isinstance(entry, Mapping):
            if isinstance(entry.get("type"), str) and "/" in entry["type"]:
                yield namespace, name
            elif name != "gazebo_ros_control":
                yield from _controllers_in(f"{namespace}/{str(name).strip('/')}", entry)
