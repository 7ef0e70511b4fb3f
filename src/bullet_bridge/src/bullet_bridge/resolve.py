"""Files of worlds and models: searched in Gazebo's folders, read, their warnings logged."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import rospkg
import rospy
from bullet_sim.description.warnings import grouped
from bullet_sim.description.world import WorldDescription, empty_world
from bullet_sim.errors import BROKEN, ModelError
from bullet_sim.files import read_file
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.xml_reader import parse
from catkin_pkg.package import InvalidPackage

if TYPE_CHECKING:
    from bullet_sim.world import World

SUFFIXES = ("", "models", "media/models", "Media/models")  # below each resource path
SCHEMES = ("package", "model", "file")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_PACKAGE = re.compile(r"package://([^/]*)/")
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


class Resolver:
    """Finds files through rospkg, Gazebo's environment variables and packages' exports.

    A resource path is a folder of GAZEBO_RESOURCE_PATH, of GAZEBO_MODEL_PATH, of a package's
    gazebo_ros export (gazebo_media_path, gazebo_model_path), the package gazebo_ros, the folder
    of the world file and that of its package. Below each, SUFFIXES are tried, too.
    """

    def __init__(self) -> None:
        self._packages = rospkg.RosPack()
        self._models: list[str] | None = None
        self._resources: list[str] | None = None
        self._world: tuple[str, ...] = ()

    def set_world(self, path: str) -> None:
        """Search next to a world file, too: in its folder and in that of its package."""
        folder = os.path.dirname(os.path.abspath(path))
        self._world = (folder, *_package_above(folder))

    def __call__(self, uri: str) -> str:
        """Absolute path of a URI's file, or of a name without a scheme.

        Raises:
            ValueError: there is no such file; names the file and the folders searched.
        """
        uri = uri.strip()
        scheme, separator, rest = uri.partition("://")
        if not separator:
            scheme, rest = "file", uri
        if not rest:
            raise ValueError("it is empty: a file needs package://, model://, file:// or a path")
        if scheme == "file":
            return self._file(rest)
        if scheme == "package":
            return self._in_package(rest)
        if scheme == "model":
            return self._model(rest)
        raise ValueError(f"scheme '{scheme}' is not one of {', '.join(SCHEMES)}")

    def missing_package(self, text: str) -> str | None:
        """Name of the first package:// of a URDF that is no package, as gazebo_ros asks for it.

        It looks at the whole text but its comments, whatever names the package there.
        """
        names = _PACKAGE.findall(_COMMENT.sub("", text))
        return next((name for name in names if not self._is_package(name)), None)

    def _is_package(self, name: str) -> bool:
        try:
            return bool(self._packages.get_path(name))
        except rospkg.ResourceNotFound:
            return False

    def world(self, path: str) -> str:
        """Path of a world file.

        Raises:
            ValueError: it does not exist; names all folders.
        """
        path = path.partition("://")[2] if path.startswith("file://") else path.strip()
        if os.path.isabs(path) or os.path.isfile(path):
            return path
        folders = [os.getcwd(), *self._all_resources()]
        for folder in folders:
            for candidate in (os.path.join(folder, path), os.path.join(folder, "worlds", path)):
                if os.path.isfile(candidate):
                    return candidate
        raise ValueError(f"world file '{path}' is in none of {', '.join(folders)}")

    def _in_package(self, rest: str) -> str:
        name, _, path = rest.partition("/")
        try:
            folder = self._packages.get_path(name)
        except rospkg.ResourceNotFound as error:
            match = self._search(rest)  # Gazebo takes package:// for model://
            if match is None:
                raise ValueError(f"package '{name}' is not on ROS_PACKAGE_PATH") from error
            return match
        path = os.path.join(folder, path)
        return _sdf_file(path) or path

    def _file(self, path: str) -> str:
        """A file's path; a relative one that is nowhere is an error."""
        if os.path.isabs(path):
            return _sdf_file(path) or (path if os.path.exists(path) else self._moved(path))
        match = self._search(path, resources_first=True)
        if match is None and os.path.exists(path):
            match = _sdf_file(path) or os.path.abspath(path)
        if match is None:
            raise ValueError(f"'{path}' is in none of {self._folders()}")
        return match

    def _moved(self, path: str) -> str:
        """A path of another machine, as saved worlds have them: in a package of this machine.

        Returns:
            The path below the first folder that is named as a package, or that Gazebo's folder of
            models has; the path itself where there is none such.
        """
        parts = path.split("/")
        for number, part in enumerate(parts[:-1]):
            rest = "/".join(parts[number + 1 :])
            match: str | None
            if part in self._packages.list():
                match = os.path.join(self._packages.get_path(part), rest)
            elif parts[number - 1 : number + 1] == [".gazebo", "models"]:
                match = self._search(rest)
            else:
                continue
            if match is not None and os.path.exists(match):
                return match
        return path

    def _model(self, rest: str) -> str:
        match = self._search(rest)
        if match is not None:
            return match
        name, _, path = rest.partition("/")
        try:
            path = os.path.join(self._packages.get_path(name), path)
            return _sdf_file(path) or path
        except rospkg.ResourceNotFound as error:
            raise ValueError(f"model '{rest}' is in none of {self._folders()}") from error

    def _search(self, path: str, resources_first: bool = False) -> str | None:
        """First file, model or else folder below the resource paths and SUFFIXES, or None."""
        groups = [self._model_paths(), self._all_resources()]
        folders = [
            os.path.join(folder, suffix, path)
            for group in (groups[::-1] if resources_first else groups)
            for folder in group
            for suffix in SUFFIXES
        ]
        matches = [folder for folder in folders if os.path.exists(folder)]
        for match in matches:
            if os.path.isfile(match):
                return match
            model = _sdf_file(match)
            if model is not None:
                return model
        return matches[0] if matches else None

    def _folders(self) -> str:
        return ", ".join((*self._model_paths(), *self._all_resources())) or "(no folder)"

    def _model_paths(self) -> list[str]:
        if self._models is None:
            folders = _listed("GAZEBO_MODEL_PATH")
            folders += exported_folders(self._packages, "gazebo_model_path")
            root = os.environ.get("PADDOCK_ROOT")
            if root:  # a launch file's <env> may have set another GAZEBO_MODEL_PATH
                folders.append(os.path.join(root, ".cache", "gazebo_models"))
            folders.append(os.path.join("~", ".gazebo", "models"))
            self._models = list(dict.fromkeys(os.path.expanduser(folder) for folder in folders))
        return self._models

    def _all_resources(self) -> list[str]:
        if self._resources is None:
            folders = _listed("GAZEBO_RESOURCE_PATH")
            try:
                folders.append(self._packages.get_path("gazebo_ros"))
            except rospkg.ResourceNotFound:
                pass  # its worlds are not here then
            folders += exported_folders(self._packages, "gazebo_media_path")
            self._resources = list(dict.fromkeys(os.path.expanduser(folder) for folder in folders))
        return [*self._resources, *self._world]


def _listed(variable: str) -> list[str]:
    return [folder for folder in os.environ.get(variable, "").split(":") if folder]


def _package_above(folder: str) -> tuple[str, ...]:
    """(folder of the package that a folder is in,), or () where it is in none."""
    while folder != os.path.dirname(folder):
        if os.path.isfile(os.path.join(folder, "package.xml")):
            return (folder,)
        folder = os.path.dirname(folder)
    return ()


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


def _sdf_file(folder: str) -> str | None:
    """The SDF file of a model's folder: the newest that its model.config names, or model.sdf."""
    names: list[tuple[tuple[int, ...], str]] = [((), "model.sdf")]
    try:
        path = os.path.join(folder, "model.config")
        config = parse(read_file(path, "file", "text_bytes"), path)
    except ModelError:
        pass  # none, or a broken one
    else:
        for element in config.iter("sdf"):
            version = tuple(map(int, re.findall(r"\d{1,9}", element.get("version") or "")))
            names.append((version, (element.text or "").strip()))
    names.sort(key=lambda entry: entry[0])  # of one version the last counts
    files = [os.path.join(folder, name) for _, name in names if name]
    return next((path for path in reversed(files) if os.path.isfile(path)), None)


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


_MODEL = re.compile(r"model://([^/\s']+)")


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
