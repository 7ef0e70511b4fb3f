"""Opens the teleop window, for a world and control that run already (needs a display).

Launch arguments and options of roslaunch, such as --screen, are handed on.
"""

from commands import environment, processes
from commands.launching import display, guard, window
from commands.launching.launch_file import LaunchFile

LAUNCH = LaunchFile("deepracer_teleop", "teleop.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch."""
    arguments = LAUNCH.check(rest)
    arguments += window.additions(arguments)
    environ = environment.ready()
    display.need_display(environ, "./run demo")
    guard.start(environ)
    processes.become(LAUNCH.command(arguments), environ)
