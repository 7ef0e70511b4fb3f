"""Starts track, car, controllers and camera, without a window.

Launch arguments and options of roslaunch, such as --screen, are handed on.
"""

from commands import environment
from commands.launching import interactive
from commands.launching.launch_file import LaunchFile

LAUNCH = LaunchFile("track_model", "world.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch."""
    arguments = LAUNCH.check(rest)
    environ = environment.ready()
    interactive.refuse_second_world(environ)
    interactive.become(LAUNCH, arguments, environ)
