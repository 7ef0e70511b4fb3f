"""Becomes roslaunch for ./run check, for which no window is required and none is started again.

A file may say that everything ends with its rviz (required="true"); there is no screen here, so
rviz ends at once. Of files that are started beside each other (TOGETHER) the last one's node of a
name stays, as a node that registers with a name ends the one that had it.
"""

import os
import pathlib
import runpy
import shutil
import sys

if __name__ == "__main__":
    sys.path[0] = str(pathlib.Path(__file__).resolve().parents[1])

from commands.windows import needs_screen  # noqa: E402

TOGETHER = "PADDOCK_CHECK_TOGETHER"  # set: the file includes several that are started by themselves


def without_required_windows(node_class):
    """Changes roslaunch's class of nodes."""
    make = node_class.__init__

    def init(self, package, node_type, *arguments, **options):
        make(self, package, node_type, *arguments, **options)
        if needs_screen(self.type):
            self.required = self.respawn = False

    node_class.__init__ = init


def keep_last_of_a_name(config_class):
    """Changes roslaunch's class of configurations, which refuses a second node of a name."""
    add = config_class.add_node

    def add_node(self, node, *arguments, **options):
        from rosgraph.names import ns_join

        def named(each):
            return ns_join(each.namespace, each.name)

        if node.name and named(node) in self.resolved_node_names:
            self.resolved_node_names.remove(named(node))
            self.nodes = [each for each in self.nodes if named(each) != named(node)]
        add(self, node, *arguments, **options)

    config_class.add_node = add_node


if __name__ == "__main__":
    real = shutil.which("roslaunch")
    if real is None:
        sys.exit("check: there is no roslaunch on the PATH")
    del sys.path[0]
    from roslaunch.core import Node

    without_required_windows(Node)
    if os.environ.get(TOGETHER):
        from roslaunch.config import ROSLaunchConfig

        keep_last_of_a_name(ROSLaunchConfig)
    runpy.run_path(real, run_name="__main__")
