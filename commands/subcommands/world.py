"""Starts track, car, controllers and camera, without a window.

Launch arguments and options of roslaunch, such as --screen, are handed on.
"""

from commands import environment, processes
from commands.launching import guard, master
from commands.launching.launch_file import LaunchFile

LAUNCH = LaunchFile("track_model", "world.launch")
USAGE = "[ARG:=VALUE ...]"


def run(_options, rest):
    """Becomes roslaunch."""
    arguments = LAUNCH.check(rest)
    environ = environment.ready()
    master.refuse_second_world(environ)
    guard.start(environ)
    processes.become(LAUNCH.command(arguments), environ)
