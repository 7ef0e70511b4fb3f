"""Writes every mesh as NAME.obj and NAME.mtl (the command make_meshes)."""

import argparse
import os
import sys

from cybertruck.meshes import trailer, truck

MESHES = {
    make.__name__: make
    for make in (
        truck.shell,
        truck.sides,
        truck.trim,
        truck.glass,
        truck.light_bar,
        truck.tail_bar,
        truck.tyre,
        truck.hub,
        trailer.trailer_box,
        trailer.trailer_trim,
        trailer.trailer_lights,
    )
}

# RGB 0..1, as urdf/materials.xacro paints them: rviz takes the colour of an OBJ from its MTL.
STEEL, TRIM, GLASS = (0.66, 0.68, 0.70), (0.10, 0.10, 0.11), (0.07, 0.09, 0.11)
COLOURS = {
    "shell": STEEL,
    "sides": STEEL,
    "trim": TRIM,
    "glass": GLASS,
    "light_bar": (1.0, 0.98, 0.90),
    "tail_bar": (0.85, 0.05, 0.05),
    "tyre": (0.06, 0.06, 0.06),
    "hub": (0.32, 0.33, 0.35),
    "trailer_box": (0.78, 0.79, 0.80),
    "trailer_trim": TRIM,
    "trailer_lights": (0.85, 0.05, 0.05),
}


def material(name):
    """Text of NAME.mtl: one plain colour."""
    colour = " ".join(f"{channel:.2f}" for channel in COLOURS[name])
    return f"newmtl {name}\nKa {colour}\nKd {colour}\nKs 0.2 0.2 0.2\nd 1\nillum 2\n"


def write(directory):
    """Write all meshes into a directory; return the paths."""
    os.makedirs(directory, exist_ok=True)
    paths = []
    for name, make in MESHES.items():
        for ending, text in ((".obj", make().to_obj(name)), (".mtl", material(name))):
            paths.append(os.path.join(directory, name + ending))
            with open(paths[-1], "w", encoding="ascii", newline="\n") as stream:
                stream.write(text)
    return paths


def main(argv=None):
    """Command line: target folder, by default that of the source tree; prints the paths."""
    default = os.path.normpath(os.path.join(os.path.dirname(__file__), "..", "..", "..", "meshes"))
    optional = "?" if os.path.isdir(default) else None  # an install space has no sources
    parser = argparse.ArgumentParser(prog="make_meshes", description=__doc__)
    parser.add_argument("directory", nargs=optional, default=default)
    for path in write(parser.parse_args(argv).directory):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
