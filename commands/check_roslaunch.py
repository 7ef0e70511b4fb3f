"""Becomes roslaunch for ./run check, for which no window is required and none is started again.

A file may say that everything ends with its rviz (required="true"); there is no screen here, so
rviz ends at once. What a file runs in a terminal's window (xterm -e) is run without the window. Of
files that are started beside each other (TOGETHER) the last one's node of a name stays, as a node
that registers with a name ends the one that had it. What each node writes goes to a file of its
own in the folder OUTPUTS, and its death to DIED there.
"""

import json
import os
import pathlib
import re
import runpy
import sys

if __name__ == "__main__":
    sys.path[0] = str(pathlib.Path(__file__).resolve().parents[1])

from commands.check_log import DIED  # noqa: E402
from commands.paths import replaced  # noqa: E402
from commands.windows import needs_screen  # noqa: E402

OUTPUTS = "PADDOCK_CHECK_OUTPUTS"
TOGETHER = "PADDOCK_CHECK_TOGETHER"  # set: the file includes several that are started by themselves


# A terminal's window as launch-prefix, up to the command that runs in it.
_WINDOW = re.compile(
    r"^\s*(?:\S*/)?(?:[xu]term|urxvt|gnome-terminal|konsole|xfce4-terminal|lxterminal|terminator"
    r"|x-terminal-emulator)\b.*?(?:\s(?:-e|-x|--|--command)(?=\s|$)|$)"
)


def without_required_windows(node_class):
    """Changes roslaunch's class of nodes."""
    make = node_class.__init__

    def init(self, package, node_type, *arguments, **options):
        make(self, package, node_type, *arguments, **options)
        if needs_screen(self.type):
            self.required = self.respawn = False
        self.launch_prefix = _WINDOW.sub("", self.launch_prefix or "").strip() or None

    node_class.__init__ = init


def keep_last_of_a_name(config_class):
    """Changes roslaunch's class of configurations, which refuses a second node of a name."""
    add = config_class.add_node

    def add_node(self, node, *arguments, **options):
        from rosgraph.names import ns_join

        def named(other):
            return ns_join(other.namespace, other.name)

        if node.name and named(node) in self.resolved_node_names:
            self.resolved_node_names.remove(named(node))
            self.nodes = [other for other in self.nodes if named(other) != named(node)]
        add(self, node, *arguments, **options)

    config_class.add_node = add_node


def keep_outputs(process_class, launch, folder):
    """Changes roslaunch's class of processes and its module that makes those of nodes."""
    configure, describe = process_class._configure_logging, process_class.get_exit_description
    create = launch.create_node_process

    def create_node_process(run_id, node, *arguments, **options):
        process = create(run_id, node, *arguments, **options)
        process.type = node.type
        return process

    def configure_logging(self):
        configure(self)
        stream = open(os.path.join(folder, self._log_name()), "ab")
        return stream, stream

    def get_exit_description(self):
        if self.exit_code:
            node = {
                "name": re.sub(r"-\d+$", "", self.name),
                "package": self.package,
                "program": os.path.basename(getattr(self, "type", self.args[0])),
                "code": self.exit_code,
                "output": self._log_name(),
                "paths": [word for word in self.args if os.path.isfile(word)],
            }
            with open(os.path.join(folder, DIED), "a", encoding="utf-8") as stream:
                stream.write(json.dumps(node) + "\n")
        return describe(self)

    launch.create_node_process = create_node_process
    process_class._configure_logging = configure_logging
    process_class.get_exit_description = get_exit_description


if __name__ == "__main__":
    real = replaced("roslaunch")
    if real is None:
        sys.exit("check: there is no roslaunch on the PATH")
    del sys.path[0]
    import roslaunch.launch
    from roslaunch.core import Node
    from roslaunch.nodeprocess import LocalProcess

    without_required_windows(Node)
    keep_outputs(LocalProcess, roslaunch.launch, os.environ[OUTPUTS])
    if os.environ.get(TOGETHER):
        from roslaunch.config import ROSLaunchConfig

        keep_last_of_a_name(ROSLaunchConfig)
    runpy.run_path(real, run_name="__main__")
