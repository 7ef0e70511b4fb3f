"""Runs everything under faults: killed and stopped processes, fuzzed calls, masters that die.

World, car, truck, camera, lidars and window run at the same time on a ROS master of their own,
without a screen. A seed draws the faults; memory, threads, files, topics, the real-time factor and
the bits of resets are monitored. out/soak/seed-S/soak.md lists what was done and what failed. Exits
0 if nothing failed, 1 if something did. docs/reliability.md lists what is guaranteed.
"""

import os

from commands import bootstrap, environment, processes
from commands.errors import CommandError
from commands.paths import ROOT, VENV_PYTHON

USAGE = "[--minutes N] [--seed S] [--stops N] [--machine [TRIAL ...]]"
PASSES_ON = True
SCRIPT = os.path.join(ROOT, "bench", "soak.py")


def add_arguments(parser):
    """Declares the soak's options, for help and completion."""
    from commands import parsing

    parsing.declare(parser, SCRIPT)


def run(arguments):
    """Becomes the soak."""
    if not os.path.exists(SCRIPT):
        raise CommandError("bench/soak.py is missing from this checkout")
    from commands.bootstrap import venv

    bootstrap.need_own()
    environ = environment.ready()
    venv.prepare_extras("test")  # its page is a client of WebSockets
    processes.become([VENV_PYTHON, SCRIPT, *arguments], environ)
