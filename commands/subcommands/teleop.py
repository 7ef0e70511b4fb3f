"""Opens the teleop window, for a world and control that run already (needs a display).

Launch arguments and options of roslaunch, such as --screen, are handed on.
"""

from commands import environment
from commands.launching import interactive
from commands.launching.launch_file import LaunchFile

LAUNCH = LaunchFile("deepracer_teleop", "teleop.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch."""
    arguments = LAUNCH.check(rest)
    arguments += interactive.window_arguments(arguments)
    environ = environment.ready()
    interactive.need_display(environ, "./run demo")
    interactive.become(LAUNCH, arguments, environ)
