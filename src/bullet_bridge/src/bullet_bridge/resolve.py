"""Worlds: found through rospkg, loaded, their warnings logged."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import rospkg
import rospy
from bullet_sim.description.warnings import grouped
from bullet_sim.description.world import WorldDescription, empty_world
from bullet_sim.errors import BROKEN
from bullet_sim.files import read_file
from bullet_sim.formats.resolve import Resolver
from bullet_sim.formats.sdf.world import parse_world
from catkin_pkg.package import InvalidPackage

if TYPE_CHECKING:
    from bullet_sim.world import World

# Worlds that Gazebo provides and the stand-in gazebo_ros does not: the empty world replaces them.
GAZEBO_WORLDS = (
    "cafe",
    "camera",
    "cessna_demo",
    "elevator",
    "elevator_ros",
    "gazebo_ros_range",
    "heightmap",
    "lift_drag_demo",
    "mud",
    "pioneer2dx",
    "pr2",
    "robocup09_spl_field",
    "robocup14_spl_field",
    "rubble",
    "simple_arm",
    "stereocamera",
    "turtlebot",
    "willowgarage",
)


class RosPackages:
    """Packages that rospkg finds."""

    def __init__(self) -> None:
        self._packages = rospkg.RosPack()

    def folder(self, name: str) -> str | None:
        """Folder of a package; None: there is none of that name."""
        try:
            return str(self._packages.get_path(name))
        except rospkg.ResourceNotFound:
            return None

    def names(self) -> Iterable[str]:
        """Names of all packages."""
        names: Iterable[str] = self._packages.list()
        return names

    def exported(self, key: str) -> list[str]:
        """See bullet_sim.formats.resolve.Packages."""
        return exported_folders(self._packages, key)


def exported_folders(packages: rospkg.RosPack, key: str) -> list[str]:
    """Folders that packages name in their <export><gazebo_ros KEY="..."/>, in order.

    Args:
        key: gazebo_model_path (models) or gazebo_media_path (worlds, materials).
    """
    folders = []
    for name in packages.list():  # rospkg overlooks <depend> of format 2
        manifest = manifest_with(key, packages, name)
        folders += [
            folder.replace("${prefix}", packages.get_path(name))
            for export in (() if manifest is None else manifest.get_export("gazebo_ros", key))
            for folder in export.split(":")
            if folder
        ]
    return folders


def manifest_with(text: str, packages: rospkg.RosPack, name: str) -> Any:
    """rospkg's manifest of a package, if a text is anywhere in it and it is not broken, or None.

    rospkg takes milliseconds for each, and few export anything.
    """
    try:
        has_text = _is_in_manifest(text, packages.get_path(name))
        return packages.get_manifest(name) if has_text else None
    except (
        *BROKEN,
        AssertionError,
        InvalidPackage,
        rospkg.InvalidManifest,
        rospkg.ResourceNotFound,
    ):
        return None


def _is_in_manifest(text: str, folder: str) -> bool:
    """Whether a text is anywhere in the manifest of a package's folder, the one rospkg reads."""
    for name in ("manifest.xml", "package.xml"):
        try:
            with open(os.path.join(folder, name), "rb") as file:
                return text.encode() in file.read()
        except OSError:
            continue
    return False


MOST_LINES, MOST_DETAILS = 100, 5000  # of one model in the log, and in its file
_details = logging.getLogger("bullet_bridge.resolve")  # goes to the node's log file alone


def log_warnings(warnings: Sequence[str], model: str = "") -> None:
    """Log one line a cause; the single messages go to the node's log file.

    Args:
        model: name of the model that they are about, for lines that do not name it.
    """
    lines = grouped(warnings)
    for line in lines[:MOST_LINES]:
        rospy.logwarn("%s", _with_name(line, model))
    if len(lines) > MOST_LINES:
        rospy.logwarn("%d more kinds of warnings are not shown", len(lines) - MOST_LINES)
    if len(lines) < len(warnings):
        for warning in warnings[:MOST_DETAILS]:
            _details.info("%s", _with_name(warning, model))


def _with_name(line: str, model: str) -> str:
    return f"model '{model}': {line}" if model and f"'{model}'" not in line else line


def load_world(world: World, path: str, resolve: Resolver) -> WorldDescription | None:
    """Load a world file; if that fails, log an error and load the empty world.

    Args:
        path: of the file, as Gazebo takes it (see Resolver.world); empty: nothing is loaded.
        resolve: Resolver; searches next to the world file from now on.

    Returns:
        The WorldDescription, or None for no path.
    """
    if not path:
        return None
    try:
        described, problem = _described(path, resolve), ""
    except ValueError as error:
        described, problem = empty_world(), _without_world(path, str(error))
    log_warnings(world.load(described))
    if problem:  # is in the log
        described.warn(problem, "world files cannot be had", path)
    return described


def _described(path: str, resolve: Resolver) -> WorldDescription:
    file = resolve.world(path)
    text = read_file(file, "world file", "text_bytes")
    resolve.set_world(file)
    return parse_world(text, resolve, file)


def _without_world(path: str, problem: str) -> str:
    """Log that there is no such world; what has been logged, or nothing for one of Gazebo's."""
    name, ending = os.path.splitext(os.path.basename(path))
    is_gazebos = not os.path.isabs(path) or "/gazebo_plugins/test/test_worlds/" in path
    if name in GAZEBO_WORLDS and ending == ".world" and is_gazebos:
        rospy.logwarn(
            "world '%s' is one of Gazebo's, which is not part of this stand-in; the empty "
            "world takes its place",
            path,
        )
        return ""
    text = f"{problem}; the empty world takes its place"
    rospy.logerr("%s", text)
    return text
