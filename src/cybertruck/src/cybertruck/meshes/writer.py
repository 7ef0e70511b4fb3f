"""The meshes of truck and trailer with their colours (the command make_meshes)."""

import os
import sys

from paddock_common.meshes.obj import MeshSet

from cybertruck.meshes import trailer, truck

MAKERS = {
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

# RGB 0..1, as urdf/materials.xacro paints them.
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
MESHES = MeshSet("cybertruck", MAKERS, COLOURS, folded=True)


def main(argv=None):
    """Command line: optional target folder; prints the paths written."""
    return MESHES.main(os.path.join(os.path.dirname(__file__), "..", "..", "..", "meshes"), argv)


if __name__ == "__main__":
    sys.exit(main())
