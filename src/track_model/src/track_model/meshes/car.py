"""The car's visual meshes with their colours (the command make_meshes)."""

import os
import sys

from paddock_common.meshes.obj import MeshSet

from track_model.meshes import parts, shell

MAKERS = {
    "body": shell.body,
    "stripe": shell.stripe,
    "trim": parts.trim,
    "glass": shell.glass,
    "headlights": parts.headlights,
    "taillights": parts.taillights,
    "tyre": parts.tyre,
    "rim": parts.rim,
}
# RGB 0..1, as urdf/materials.xacro paints them.
COLOURS = {
    "body": (0.05, 0.25, 0.75),
    "stripe": (0.95, 0.95, 0.95),
    "trim": (0.09, 0.09, 0.10),
    "glass": (0.16, 0.21, 0.26),
    "headlights": (1.0, 0.96, 0.75),
    "taillights": (0.85, 0.05, 0.05),
    "tyre": (0.05, 0.05, 0.05),
    "rim": (0.75, 0.77, 0.80),
}
MESHES = MeshSet("track_model", MAKERS, COLOURS, specular=0.1, digits=3)


def main(argv=None):
    """Command line: optional target folder; prints the paths written."""
    return MESHES.main(os.path.join(os.path.dirname(__file__), "..", "..", "..", "meshes"), argv)


if __name__ == "__main__":
    sys.exit(main())
