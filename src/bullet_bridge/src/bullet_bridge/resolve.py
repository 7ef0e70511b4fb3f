"""URIs of models and meshes -> files: package://, model://, file:// and plain paths."""

import os
import xml.etree.ElementTree as ElementTree

import rospkg
from catkin_pkg.package import InvalidPackage


class Resolver:
    """Finds files through rospkg, GAZEBO_MODEL_PATH and the gazebo_ros exports of packages."""

    def __init__(self):
        self._packages = rospkg.RosPack()
        self._model_paths = None

    def __call__(self, uri):
        """Absolute path of a URI's file.

        Raises:
            ValueError: nothing is found; names the file and the folders searched.
        """
        scheme, _, rest = uri.partition("://")
        if not rest:
            if os.path.isabs(uri):
                return _sdf_file(uri) or uri
            raise ValueError("a mesh needs package://, model://, file:// or an absolute path")
        if scheme == "file":
            return self._file(rest)
        if scheme == "package":
            name, _, path = rest.partition("/")
            path = os.path.join(self._package(name), path)
            return _sdf_file(path) or path
        if scheme == "model":
            return self._model(rest)
        raise ValueError(f"scheme '{scheme}' is not one of package, model, file")

    def _package(self, name):
        try:
            return self._packages.get_path(name)
        except rospkg.ResourceNotFound as error:
            raise ValueError(f"package '{name}' is not on ROS_PACKAGE_PATH") from error

    def _file(self, path):
        """A file:// path; a relative one is searched as Gazebo does, else returned unchanged."""
        places = (
            []
            if os.path.isabs(path)
            else [
                folder for folder in os.environ.get("GAZEBO_RESOURCE_PATH", "").split(":") if folder
            ]
        )
        if not os.path.isabs(path):
            places += exported_folders(self._packages, "gazebo_media_path") + self._folders()
        found = [os.path.join(place, path) for place in places]
        path = next((place for place in found if os.path.exists(place)), path)
        return _sdf_file(path) or path

    def _model(self, rest):
        for folder in self._folders():
            path = os.path.join(folder, rest)
            model = _sdf_file(path)
            if model:
                return model
            if "/" in rest.strip("/") and os.path.exists(path):  # a file or material folder
                return path
        name, _, path = rest.partition("/")
        try:
            return os.path.join(self._packages.get_path(name), path)
        except rospkg.ResourceNotFound as error:
            raise ValueError(
                f"model '{rest}' is in none of {', '.join(self._folders()) or '(no model folder)'}"
            ) from error

    def _folders(self):
        if self._model_paths is None:
            folders = os.environ.get("GAZEBO_MODEL_PATH", "").split(":")
            folders += exported_folders(self._packages, "gazebo_model_path")
            folders.append(os.path.join("~", ".gazebo", "models"))
            self._model_paths = [os.path.expanduser(folder) for folder in folders if folder]
        return self._model_paths


def exported_folders(packages, key):
    """Folders that packages name in their <export><gazebo_ros KEY="..."/>, in order.

    Args:
        packages: rospkg.RosPack.
        key: gazebo_model_path (models) or gazebo_media_path (worlds, materials).
    """
    folders = []
    for name in packages.list():  # rospkg overlooks <depend> of format 2
        try:
            exports = packages.get_manifest(name).get_export("gazebo_ros", key)
        except (InvalidPackage, rospkg.InvalidManifest, rospkg.ResourceNotFound):
            continue  # a broken package.xml has none
        folders += [
            folder.replace("${prefix}", packages.get_path(name))
            for export in exports
            for folder in export.split(":")
            if folder
        ]
    return folders


def _sdf_file(folder):
    """The SDF file of a model's folder: the last that its model.config names, or model.sdf."""
    names = ["model.sdf"]
    try:
        config = ElementTree.parse(os.path.join(folder, "model.config"))
        names += [(element.text or "").strip() for element in config.iter("sdf")]
    except (OSError, ElementTree.ParseError):
        pass  # none, or a broken one
    found = [os.path.join(folder, name) for name in names if name]
    return next((path for path in reversed(found) if os.path.isfile(path)), None)


def find_world(path):
    """Path of a world file, searched as Gazebo does.

    A path that exists is returned unchanged; a relative one is searched in the folders of
    GAZEBO_RESOURCE_PATH, in the package gazebo_ros and in packages' gazebo_media_path exports.

    Raises:
        ValueError: not found; names the folders searched.
    """
    if os.path.isabs(path) or os.path.isfile(path):
        return path
    places = [os.getcwd()]
    places += [f for f in os.environ.get("GAZEBO_RESOURCE_PATH", "").split(":") if f]
    packages = rospkg.RosPack()
    try:
        places.append(packages.get_path("gazebo_ros"))
    except rospkg.ResourceNotFound:
        places.append("package gazebo_ros (not on ROS_PACKAGE_PATH)")
    places += exported_folders(packages, "gazebo_media_path")
    for place in places:
        found = os.path.join(place, path)
        if os.path.isfile(found):
            return found
    raise ValueError(f"world file '{path}' is in none of {', '.join(places)}")
