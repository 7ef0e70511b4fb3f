"""Wavefront OBJ and MTL files of meshes, and the command make_meshes that writes them."""

import argparse
import os
from dataclasses import dataclass

import numpy as np

from paddock_common.meshes.solids import area_vector, fan

LEAST_AREA = 1e-10  # faces below twice this have no normal and are left out [m^2]


@dataclass(frozen=True)
class MeshSet:
    """The meshes of one description.

    Attributes:
        package: Package whose make_meshes makes them, for the files' first line.
        makers: Name -> function without arguments that makes the Mesh.
        colours: Name -> RGB 0..1. rviz takes the colour of an OBJ from its MTL.
        specular: Brightness of highlights, 0..1.
        digits: Decimals of the normals; positions have 0.01 mm.
        folded: A bent face shows its triangles, each with its own normal; else it has one normal.
    """

    package: str
    makers: dict
    colours: dict
    specular: float = 0.2
    digits: int = 4
    folded: bool = False

    def obj(self, name):
        """Text of NAME.obj: triangles, one normal for each flat face."""
        mesh = self.makers[name]()
        faces = mesh.triangles() if self.folded else mesh.faces
        head = [f"# made by {self.package} make_meshes", f"mtllib {name}.mtl"]
        head += [f"o {name}", f"usemtl {name}"]
        return "\n".join(head + obj_lines(faces, self.digits)) + "\n"

    def mtl(self, name):
        """Text of NAME.mtl: one plain colour."""
        colour = " ".join(f"{channel:.2f}" for channel in self.colours[name])
        shine = " ".join([f"{self.specular:.1f}"] * 3)
        return f"newmtl {name}\nKa {colour}\nKd {colour}\nKs {shine}\nd 1\nillum 2\n"

    def write(self, directory):
        """Write every mesh as NAME.obj and NAME.mtl into a directory; return the paths."""
        os.makedirs(directory, exist_ok=True)
        paths = []
        for name in self.makers:
            for ending, text in ((".obj", self.obj(name)), (".mtl", self.mtl(name))):
                paths.append(os.path.join(directory, name + ending))
                with open(paths[-1], "w", encoding="ascii", newline="\n") as stream:
                    stream.write(text)
        return paths

    def main(self, default, argv=None):
        """Command line: target folder, by default that of the source tree; prints the paths.

        Args:
            default: Folder to write into when none is named.
            argv: Arguments; None: those of the process.
        """
        parser = argparse.ArgumentParser(
            prog="make_meshes", description=f"Writes the meshes of {self.package}."
        )
        default = os.path.normpath(default)
        optional = "?" if os.path.isdir(default) else None  # an install space has no sources
        parser.add_argument("directory", nargs=optional, default=default)
        for path in self.write(parser.parse_args(argv).directory):
            print(path)
        return 0


def obj_lines(faces, digits):
    """Lines of an OBJ: positions, normals, triangles, each position and normal once.

    Args:
        faces: (P, 3) polygons [m].
        digits: Decimals of the normals.
    """
    points, normals, triangles = {}, {}, []
    for face in faces:
        across = area_vector(face)
        length = np.linalg.norm(across)
        if length < LEAST_AREA:
            continue
        normal = normals.setdefault(_text(across / length, digits), len(normals) + 1)
        corners = [points.setdefault(_text(corner, 5), len(points) + 1) for corner in face]
        for triangle in fan(corners):  # PyBullet's loader wants triangles
            if len(set(triangle)) == 3:
                triangles.append("f " + " ".join(f"{corner}//{normal}" for corner in triangle))
    return [f"v {text}" for text in points] + [f"vn {text}" for text in normals] + triangles


def _text(vector, digits):
    # Adding 0.0 turns -0.0 into 0.0.
    return " ".join(f"{round(float(value), digits) + 0.0:g}" for value in vector)
