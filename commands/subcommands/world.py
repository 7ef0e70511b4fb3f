"""Starts track, car, controllers and camera, without a window.

Launch arguments and options of roslaunch, such as --screen, are handed on.
"""

from commands import environment, launching
from commands.launching import LaunchFile

LAUNCH = LaunchFile("track_model", "world.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch."""
    arguments = LAUNCH.check(rest)
    environ = environment.ready()
    launching.refuse_second_world(environ)
    launching.become(LAUNCH, arguments, environ)
