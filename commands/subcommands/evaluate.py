"""Lets a trained policy drive from unseen starts, and other drivers beside it.

Every driver starts at the same places: laps made, lap times, distance from the center line, why a
run ended. The table is printed; out/evaluate/NAME/ has it as report.json, with an image of the
ways for each track. Tracks that were not trained on are welcome.
"""

import json
import os
import re

from commands import environment, launching, locks, parsing, processes
from commands.paths import OUT, VENV_PYTHON

USAGE = "NAME [--track T ...] [--starts N]"


def add_arguments(parser):
    """Declares policy, tracks and starts."""
    starts = parsing.whole_number("starts", 1, 1000)
    tracks = "as of ./run lap; several are welcome (default: the one it was trained on)"
    parsing.add_options(
        parser,
        ("policy", "NAME", launching.resolve_policy, None, "of a training, or an .onnx file"),
        ("--track", "T", launching.resolve_track, None, tracks, "+"),
        ("--starts", "N", starts, 10, "of each driver on each track (10)"),
    )


def run(options, _rest):
    """Becomes the evaluation."""
    from commands.bootstrap import venv

    environ = environment.ready()
    venv.prepare_extras("gym")
    settings = launching.policy_settings(options.policy)
    name = settings.get("name") or re.sub(r"\.onnx$", "", os.path.basename(options.policy))
    name = parsing.folder_name(str(name))  # settings may be from elsewhere
    table = {
        "policy": options.policy,
        "tracks": options.track or [],
        "starts": options.starts,
        "walls": settings.get("walls"),
        "folder": os.path.join(OUT, "evaluate", name),
    }
    locks.take_results(table["folder"])
    words = ["paddock_gym.evaluation.cli", json.dumps(table)]
    processes.become_module(VENV_PYTHON, words, environ)
