"""Becomes roslaunch for ./run check, for which no window is required and none is started again.

A file may say that everything ends with its rviz (required="true"); there is no screen here, so
rviz ends at once.
"""

import pathlib
import runpy
import shutil
import sys

if __name__ == "__main__":
    sys.path[0] = str(pathlib.Path(__file__).resolve().parents[1])

from commands.windows import needs_screen  # noqa: E402


def without_required_windows(node_class):
    """Changes roslaunch's class of nodes."""
    make = node_class.__init__

    def init(self, package, node_type, *arguments, **options):
        make(self, package, node_type, *arguments, **options)
        if needs_screen(self.type):
            self.required = self.respawn = False

    node_class.__init__ = init


if __name__ == "__main__":
    real = shutil.which("roslaunch")
    if real is None:
        sys.exit("check: there is no roslaunch on the PATH")
    del sys.path[0]
    from roslaunch.core import Node

    without_required_windows(Node)
    runpy.run_path(real, run_name="__main__")
