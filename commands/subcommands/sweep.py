"""Tries many settings of a training, or many gains, and tells which were best.

FILE.yaml names what is tried (of: train, pursuit or goal), the options that stay (fixed) and those
that differ (over: lists of values, or low and high). A grid tries all of them; Optuna's tpe and
random search do so many trials. out/sweep/NAME/ gets table.csv, plots and the files of every trial;
the same command again goes on with what is left. docs/sweep.md has examples.
"""

import json
import os
import re

from commands import environment, processes
from commands.errors import UsageError
from commands.paths import OUT, VENV_PYTHON

USAGE = "FILE.yaml [--name NAME]"


def add_arguments(parser):
    """Declares file and name."""
    parser.add_argument("file", metavar="FILE.yaml", type=_file, help="what is tried")
    parser.add_argument(
        "--name", metavar="NAME", type=_name, help="of the folder (the file's, without .yaml)"
    )


def run(options, _rest):
    """Becomes the sweep."""
    from commands.bootstrap import venv

    environ = environment.ready()
    venv.prepare_extras(*(["learning"] if trains(options.file) else []), "sweep")
    arguments = ["-m", "paddock_gym.sweep.cli", json.dumps(wanted(options))]
    processes.become([VENV_PYTHON, *arguments], environ)


def wanted(options):
    """Gives file and folder of the sweep."""
    name = options.name or _name(os.path.splitext(os.path.basename(options.file))[0])
    return {"file": options.file, "folder": os.path.join(OUT, "sweep", name)}


def trains(path):
    """Tells whether a sweep's file asks for trainings; what is wrong in it, the sweep tells."""
    with open(path, encoding="utf-8", errors="replace") as stream:
        return any(re.match(r"of\s*:\s*[\"']?train\b", line) for line in stream)


def _file(value):
    if not os.path.isfile(value):
        raise UsageError(f"there is no file {value!r}")
    return os.path.realpath(value)


def _name(value):
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", value):
        raise UsageError(f"name is {value!r}; it must be letters, digits, '_', '-' and '.'")
    return value
