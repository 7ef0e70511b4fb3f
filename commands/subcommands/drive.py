"""Starts the track, the car and the teleop window; without a display, the same as demo."""

import os

from commands import environment, processes
from commands.errors import say
from commands.launching import display, guard, master, window
from commands.launching.launch_file import LaunchFile
from commands.subcommands import demo

LAUNCH = LaunchFile("deepracer_teleop", "drive.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch, or runs the demo."""
    if not rest and not display.has_display(os.environ):
        say("no display (DISPLAY is not set): running ./run demo")
        return demo.run(None, [])
    arguments = LAUNCH.check(rest)
    arguments += window.additions(arguments)
    environ = environment.ready()
    display.need_display(environ, " ".join(["./run demo", *rest]))
    master.refuse_second_world(environ)
    guard.start(environ)
    return processes.become(LAUNCH.command(arguments), environ)
