"""Starts a launch file of yours, and commands its robot by a policy of Paddock/Robot-v0.

The policy's file says which topics it observes and commands (paddock_gym.envs.describe). A policy
of the task goal needs --goal X Y, in the world. For example:
  ./run drive-by policy.onnx my_robot my_robot.launch gui:=false --goal 2 1.5
"""

import os
import tempfile

from commands import environment, launching, processes, supervisor
from commands.bootstrap import ros, venv
from commands.parsing import add_options, existing_file
from commands.subcommands.check import files_of, together

USAGE = "POLICY.onnx PACKAGE FILE.launch [--goal X Y] [ARG:=VALUE ...]"
LAUNCH = None  # takes the arguments of any launch file


def add_arguments(parser):
    """Declares policy, launch file and goal."""
    parser.add_argument("policy", metavar="POLICY.onnx", type=existing_file, help="its file")
    parser.add_argument("package", metavar="PACKAGE", help="with the launch file")
    parser.add_argument("file", metavar="FILE.launch", help="that it learned in")
    add_options(parser, ("--goal", ("X", "Y"), float, None, "in the world [m]", 2))


def run(options, rest):
    """Becomes roslaunch."""
    environ = environment.ready()
    venv.prepare_extras("gym")
    launching.refuse_second_world(environ)
    files = files_of(options.package, options.file, rest)
    arguments = [f"policy:={os.path.realpath(options.policy)}"]
    if options.goal:
        arguments.append("goal:={:g} {:g}".format(*options.goal))
    folder = tempfile.mkdtemp(prefix="paddock_drive_by_")
    files.append(("paddock_gym", "drive_by.launch", arguments))
    path = together(files, os.path.join(folder, "drive_by.launch"), environ)
    supervisor.start(environ)
    processes.become([ros.python(), launching.ROSLAUNCH, path], environ)
