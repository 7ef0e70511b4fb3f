"""Starts the track, the car and the teleop window; without a display, the same as demo."""

import os

from commands import environment
from commands.errors import say
from commands.launching import interactive
from commands.launching.launch_file import LaunchFile
from commands.subcommands import demo

LAUNCH = LaunchFile("deepracer_teleop", "drive.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch, or runs the demo."""
    if not rest and not interactive.has_display(os.environ):
        say("no display (DISPLAY is not set): running ./run demo")
        return demo.run(None, [])
    arguments = LAUNCH.check(rest)
    arguments += interactive.window_arguments(arguments)
    environ = environment.ready()
    interactive.need_display(environ, " ".join(["./run demo", *rest]))
    interactive.refuse_second_world(environ)
    return interactive.become(LAUNCH, arguments, environ)
