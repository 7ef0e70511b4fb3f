"""Starts the track, the car and the teleop window; without a display, the same as demo."""

import os

from commands import environment, launching
from commands.errors import say
from commands.launching import LaunchFile
from commands.subcommands import demo

LAUNCH = LaunchFile("deepracer_teleop", "drive.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch, or runs the demo."""
    if not rest and not launching.has_display(os.environ):
        say("no display (DISPLAY is not set): running ./run demo")
        return demo.run(None, [])
    arguments = LAUNCH.check(rest)
    arguments += launching.window_arguments(arguments)
    environ = environment.ready()
    launching.need_display(" ".join(["./run demo", *rest]))
    launching.refuse_second_world(environ)
    return launching.become(LAUNCH, arguments, environ)
