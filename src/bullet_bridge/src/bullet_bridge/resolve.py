"""URIs of models and meshes -> files: package://, model://, file:// and plain paths."""

import os

import rospkg


class Resolver:
    """Finds files through rospkg, GAZEBO_MODEL_PATH and the gazebo_ros exports of packages."""

    def __init__(self):
        self._packages = rospkg.RosPack()
        self._model_paths = None

    def __call__(self, uri):
        """Absolute path of a URI's file.

        Raises:
            ValueError: nothing is found; names what was looked for and where.
        """
        scheme, _, rest = uri.partition('://')
        if not rest:
            if os.path.isabs(uri):
                return uri
            raise ValueError('a mesh needs package://, model://, file:// or an absolute path')
        if scheme == 'file':
            return rest
        if scheme == 'package':
            name, _, path = rest.partition('/')
            return os.path.join(self._package(name), path)
        if scheme == 'model':
            return self._model(rest)
        raise ValueError(f"scheme '{scheme}' is not one of package, model, file")

    def _package(self, name):
        try:
            return self._packages.get_path(name)
        except rospkg.ResourceNotFound as error:
            raise ValueError(f"package '{name}' is not on ROS_PACKAGE_PATH") from error

    def _model(self, rest):
        for folder in self._folders():
            path = os.path.join(folder, rest)
            if os.path.isfile(os.path.join(path, 'model.sdf')):
                return os.path.join(path, 'model.sdf')
            if os.path.isfile(path):
                return path
        name, _, path = rest.partition('/')
        try:
            return os.path.join(self._packages.get_path(name), path)
        except rospkg.ResourceNotFound as error:
            raise ValueError(f"model '{rest}' is in none of "
                             f"{', '.join(self._folders()) or '(no model folder)'}") from error

    def _folders(self):
        if self._model_paths is None:
            folders = os.environ.get('GAZEBO_MODEL_PATH', '').split(':')
            for name in self._packages.get_depends_on('gazebo_ros', implicit=False):
                exports = self._packages.get_manifest(name).get_export(
                    'gazebo_ros', 'gazebo_model_path')
                folders += [e.replace('${prefix}', self._packages.get_path(name))
                            for e in exports]
            self._model_paths = [folder for folder in folders if folder]
        return self._model_paths


def find_world(path):
    """Path of a world file, looked for as Gazebo does.

    A path that exists is taken as it is; a relative one is then looked for in the folders of
    GAZEBO_RESOURCE_PATH and in the package gazebo_ros.

    Raises:
        ValueError: it is nowhere; names all places.
    """
    if os.path.isabs(path) or os.path.isfile(path):
        return path
    places = [os.getcwd()]
    places += [f for f in os.environ.get('GAZEBO_RESOURCE_PATH', '').split(':') if f]
    try:
        places.append(rospkg.RosPack().get_path('gazebo_ros'))
    except rospkg.ResourceNotFound:
        places.append('package gazebo_ros (not on ROS_PACKAGE_PATH)')
    for place in places:
        found = os.path.join(place, path)
        if os.path.isfile(found):
            return found
    raise ValueError(f"world file '{path}' is in none of {', '.join(places)}")
