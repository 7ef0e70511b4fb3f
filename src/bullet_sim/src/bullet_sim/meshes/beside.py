"""Files that a mesh names, such as pictures: where it says, or where Gazebo looks for them."""

import os
import re
from urllib.parse import unquote

from bullet_sim.errors import ModelError
from bullet_sim.meshes.looks import TooLarge, opened

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".tif", ".tiff")
TEXTURES = os.path.join("..", "materials", "textures")  # of a Gazebo model, beside its meshes


class Beside:
    """Reads files for trimesh, in the place of its own resolver, which stays in one folder.

    Args:
        path: of the mesh.
    """

    def __init__(self, path):
        self.faults = []  # of pictures that cannot be used, which trimesh leaves out silently
        self._folder = os.path.dirname(os.path.abspath(path))

    def get(self, name):
        """Bytes of a file by the name that the mesh has for it.

        A name counts as it is, then without its folders, beside the mesh and in TEXTURES.

        Raises:
            FileNotFoundError: it is in none of these places.
        """
        name = unquote(name.strip().removeprefix("file://"))
        plain = re.split(r"[\\/]", name)[-1]
        for place in (name, plain, os.path.join(TEXTURES, plain)):
            path = os.path.normpath(os.path.join(self._folder, place))
            if os.path.isfile(path):
                return self._read(path)
        raise FileNotFoundError(f"'{name}' is neither in '{self._folder}' nor in its {TEXTURES}")

    def _read(self, path):
        with open(path, "rb") as file:
            if path.lower().endswith(PICTURES):
                try:
                    opened(file)
                except ModelError as error:
                    self.faults.append(str(error))
                    if isinstance(error, TooLarge):
                        raise FileNotFoundError(str(error)) from error
                file.seek(0)
            return file.read()

    __getitem__ = get  # as trimesh asks for material libraries
