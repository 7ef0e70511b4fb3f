"""Measures what the simulator costs on this machine, and prints JSON and a table.

bench.json and the log go to out/bench/. Nothing else should run meanwhile. Ratios come from nine
pairs of short rounds and are printed with their spread; all of it takes some 20 minutes. --quick
takes some five, its figures are not to be quoted. --save writes the results of each section to
bench/results/SECTION.json, from which documents take them. docs/performance.md says what the
figures mean.
"""

import os

from commands import bootstrap, environment, locks, processes, supervisor
from commands.errors import CommandError
from commands.paths import OUT, ROOT, VENV_PYTHON

USAGE = "[--quick | --save] [--only SECTION ...]"
PASSES_ON = True
SCRIPT = os.path.join(ROOT, "bench", "bench.py")


def add_arguments(parser):
    """Declares the benchmark's options, for help and completion."""
    from commands import parsing

    parsing.declare(parser, SCRIPT)
    if parser.option("--only") is not None:
        parser.option("--only").help = ", ".join(sections())


def complete(words):
    """Lists the sections, after --only."""
    return sections() if "--only" in words else []


def sections():
    """Lists what can be measured."""
    from commands import parsing

    return parsing.keys(
        os.path.join(os.path.dirname(SCRIPT), "sections", "__init__.py"), "SECTIONS"
    )


def run(arguments):
    """Becomes the benchmark."""
    if arguments[:1] == ["--"]:
        arguments = arguments[1:]
    if not os.path.exists(SCRIPT):
        raise CommandError("bench/bench.py is missing from this checkout")
    from commands.bootstrap import venv

    bootstrap.need_own()
    environ = environment.ready()
    venv.prepare_extras("gym", "test")
    locks.take_results(os.path.join(OUT, "bench"))
    supervisor.start(environ, "the benchmark")  # which may be killed with worlds of its own
    processes.become([VENV_PYTHON, SCRIPT, *arguments], environ)
