"""Files of worlds and models: searched in packages and in Gazebo's folders."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable
from typing import Protocol

from bullet_sim.errors import ModelError
from bullet_sim.files import read_file
from bullet_sim.xml_reader import parse

NEWEST_SDF = (1, 7, 0)  # that sdformat 9 reads
SUFFIXES = ("", "models", "media/models", "Media/models")  # below each resource path
SCHEMES = ("package", "model", "file")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_PACKAGE = re.compile(r"package://([^/]*)/")


DEBIANS = "/usr/share"  # where Debian has packages of ROS


class Packages(Protocol):
    """What finds packages."""

    def folder(self, name: str) -> str | None:
        """Folder of a package; None: there is none of that name."""

    def names(self) -> Iterable[str]:
        """Names of all packages."""

    def exported(self, key: str) -> list[str]:
        """Folders that packages name in their <export><gazebo_ros KEY="..."/>, in order.

        Args:
            key: gazebo_model_path (models) or gazebo_media_path (worlds, materials).
        """


class FolderPackages:
    """Packages below folders, without ROS.

    Args:
        folders: searched first, before those of ROS_PACKAGE_PATH and Debian's; of a package itself
            its neighbours count, too.
    """

    def __init__(self, folders: Iterable[str] = ()) -> None:
        above = [part for folder in folders for part in _package_above(os.path.abspath(folder))]
        self._roots = [*above, *map(os.path.dirname, above), *listed("ROS_PACKAGE_PATH")]
        self._found: dict[str, str] | None = None

    def _all(self) -> dict[str, str]:
        if self._found is None:
            self._found = {}
            for root in filter(os.path.isdir, self._roots):
                for folder, below, files in os.walk(root, followlinks=True):
                    if "CATKIN_IGNORE" in files:
                        below.clear()
                    elif "package.xml" in files:
                        below.clear()
                        self._found.setdefault(_package_name(folder), folder)
                    below[:] = sorted(name for name in below if not name.startswith("."))
            for file in sorted(glob.glob(f"{DEBIANS}/*/package.xml")):
                folder = os.path.dirname(file)
                self._found.setdefault(_package_name(folder), folder)
        return self._found

    def folder(self, name: str) -> str | None:
        """Folder of a package; None: there is none of that name."""
        return self._all().get(name)

    def names(self) -> Iterable[str]:
        """Names of all packages."""
        return self._all()

    def exported(self, key: str) -> list[str]:
        """See Packages."""
        folders = []
        for folder in self._all().values():
            with open(os.path.join(folder, "package.xml"), encoding="utf-8", errors="replace") as f:
                text = f.read()
            for export in re.findall(rf'<gazebo_ros\b[^>]*\b{key}\s*=\s*"([^"]*)"', text):
                parts = export.replace("${prefix}", folder).split(":")
                folders += [part for part in parts if part]
        return folders


def _package_name(folder: str) -> str:
    path = os.path.join(folder, "package.xml")
    with open(path, encoding="utf-8", errors="replace") as file:
        found = re.search(r"<name>\s*([^<\s]+)\s*</name>", file.read())
    return found.group(1) if found else os.path.basename(folder)


class Resolver:
    """Finds files in packages, Gazebo's environment variables and packages' exports.

    A resource path is a folder of GAZEBO_RESOURCE_PATH, of GAZEBO_MODEL_PATH, of a package's
    gazebo_ros export (gazebo_media_path, gazebo_model_path), the package gazebo_ros, the folder
    of the world file and that of its package. Below each, SUFFIXES are tried, too.

    Args:
        packages: what finds packages; None: FolderPackages of ROS_PACKAGE_PATH.
    """

    def __init__(self, packages: Packages | None = None) -> None:
        self._packages = FolderPackages() if packages is None else packages
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
        return next((name for name in names if not self._packages.folder(name)), None)

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
        folder = self._packages.folder(name)
        if folder is None:
            match = self._search(rest)  # Gazebo takes package:// for model://
            if match is None:
                raise ValueError(f"package '{name}' is not on ROS_PACKAGE_PATH")
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
            if part in self._packages.names():
                match = os.path.join(self._packages.folder(part) or "", rest)
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
        folder = self._packages.folder(name)
        if folder is None:
            raise ValueError(f"model '{rest}' is in none of {self._folders()}")
        path = os.path.join(folder, path)
        return _sdf_file(path) or path

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
            folders = listed("GAZEBO_MODEL_PATH")
            folders += self._packages.exported("gazebo_model_path")
            root = os.environ.get("PADDOCK_ROOT")
            if root:  # a launch file's <env> may have set another GAZEBO_MODEL_PATH
                folders.append(os.path.join(root, ".cache", "gazebo_models"))
            folders.append(os.path.join("~", ".gazebo", "models"))
            self._models = list(dict.fromkeys(os.path.expanduser(folder) for folder in folders))
        return self._models

    def _all_resources(self) -> list[str]:
        if self._resources is None:
            folders = listed("GAZEBO_RESOURCE_PATH")
            own = self._packages.folder("gazebo_ros")
            folders += [] if own is None else [own]  # else its worlds are not here
            folders += self._packages.exported("gazebo_media_path")
            self._resources = list(dict.fromkeys(os.path.expanduser(folder) for folder in folders))
        return [*self._resources, *self._world]


def listed(variable: str) -> list[str]:
    return [folder for folder in os.environ.get(variable, "").split(":") if folder]


def _package_above(folder: str) -> tuple[str, ...]:
    """(folder of the package that a folder is in,), or () where it is in none."""
    while folder != os.path.dirname(folder):
        if os.path.isfile(os.path.join(folder, "package.xml")):
            return (folder,)
        folder = os.path.dirname(folder)
    return ()


def _sdf_file(folder: str) -> str | None:
    """The SDF file of a model's folder: the one that its model.config names, or else model.sdf."""
    names = (_named_file(folder), "model.sdf")
    files = [os.path.join(folder, name) for name in names if name]
    return next((path for path in files if os.path.isfile(path)), None)


def _named_file(folder: str) -> str:
    """The file that model.config, or manifest.xml of old, names; "" where there is none.

    As getBestSupportedModelVersion of sdformat 9: the highest version that it can read, of one
    version the first; the first of all where it can read none.
    """
    for name in ("model.config", "manifest.xml"):
        path = os.path.join(folder, name)
        if os.path.isfile(path):
            break
    try:
        config = parse(read_file(path, "file", "text_bytes"), path)
    except ModelError:  # none, or a broken one
        return ""
    elements = config.findall("sdf") if config.tag == "model" else []
    best, version = (elements[0] if elements else None), (0, 0, 0)
    for element in elements:
        parts = [*map(int, re.findall(r"\d{1,9}", element.get("version") or "")), 0, 0, 0]
        own = (parts[0], parts[1], parts[2])
        if version < own <= NEWEST_SDF:
            best, version = element, own
    return "" if best is None else (best.text or "").strip()
