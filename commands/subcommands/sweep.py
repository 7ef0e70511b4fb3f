"""Tries many settings of a training, or many gains, and tells which were best.

FILE.yaml names what is tried (of: train, pursuit or goal), the options that stay (fixed) and those
that differ (over: lists of values, or low and high). A grid tries all of them; Optuna's tpe and
random search do so many trials. out/sweep/NAME/ gets table.csv, plots and the files of every trial;
the same command again goes on with what is left. docs/sweep.md has examples.
"""

import json
import os
import re

from commands import environment, locks, parsing, processes
from commands.paths import OUT, VENV_PYTHON

USAGE = "FILE.yaml [--name NAME]"


def add_arguments(parser):
    """Declares file and name."""
    name = "of the folder (the file's, without .yaml)"
    parsing.add_options(
        parser,
        ("file", "FILE.yaml", parsing.existing_file, None, "what is tried"),
        ("--name", "NAME", parsing.folder_name, None, name),
    )


def run(options, _rest):
    """Becomes the sweep."""
    from commands.bootstrap import venv

    environ = environment.ready()
    venv.prepare_extras(*(["learning"] if trains(options.file) else []), "sweep")
    table = wanted(options)
    locks.take_results(table["folder"])
    words = ["paddock_gym.sweep.cli", json.dumps(table)]
    processes.become_module(VENV_PYTHON, words, environ)


def wanted(options):
    """Returns file and folder of the sweep."""
    name = options.name or parsing.folder_name(os.path.splitext(os.path.basename(options.file))[0])
    return {"file": options.file, "folder": os.path.join(OUT, "sweep", name)}


def trains(path):
    """Returns whether a sweep's file asks for trainings; what is wrong in it, the sweep tells."""
    with open(path, encoding="utf-8", errors="replace") as stream:
        return any(re.match(r"of\s*:\s*[\"']?train\b", line) for line in stream)
