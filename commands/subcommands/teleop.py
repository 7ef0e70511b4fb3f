"""Opens the teleop window, for a world and control that run already (needs a display).

Launch arguments and options of roslaunch, such as --screen, are handed on.
"""

from commands import environment, launching
from commands.launching import LaunchFile

LAUNCH = LaunchFile("deepracer_teleop", "teleop.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch."""
    arguments = LAUNCH.check(rest)
    arguments += launching.window_arguments(arguments)
    environ = environment.ready()
    launching.need_display("./run demo")
    launching.become(LAUNCH, arguments, environ)
