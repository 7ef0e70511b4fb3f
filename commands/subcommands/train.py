"""Learns to drive: PPO on this machine's cores, without a GPU and without ROS.

Everything goes to out/train/NAME/: policy.onnx (what ./run lap --driver policy and ./run evaluate
take), report.json, film and replay.html of the best lap, the learning curve, a map of where runs
ended, logs and checkpoints. Ctrl-C ends in order and keeps all; --resume goes on. A new training of
the same name empties the folder. The first time it installs Debian's torch and stable-baselines3.
reward_function.py, model_metadata.json and hyperparameters.json of AWS DeepRacer run as they are.
--env backing teaches the Cyber Truck to back its trailer instead. With --ray the workers are actors
of Ray, on this machine or on several (./run cluster); more than two workers for each core mean
--ray auto. docs/learning.md tells more.
"""

import json
import os
import re

from commands import environment, launching, locks, parsing, processes
from commands.errors import UsageError
from commands.paths import OUT, VENV_PYTHON

USAGE = "[NAME] [--track T] [--observation O] [OPTIONS]"
OBSERVATIONS = ("state", "lidar", "camera")
RACES = ("time_trial", "object_avoidance", "head_to_bot")
RANDOM = ("start", "friction", "mass", "latency", "camera", "light", "colours")
STEPS = {"state": 60_000, "lidar": 200_000, "camera": 300_000, "backing": 200_000}
WORLDS = 10  # side by side: as many as there are starts that end a training
ENVS = ("deepracer", "backing")
OF_THE_CAR = ("track", "observation", "reward", "metadata", "race", "randomize", "walls")


def add_arguments(parser):
    """Declares what can be chosen; what is not given is the default, or as before (--resume)."""
    parser.add_argument(
        "name", nargs="?", default="first", metavar="NAME", type=parsing.folder_name,
        help="the folder (first)",
    )  # fmt: skip
    number, file, one_of = parsing.whole_number, parsing.existing_file, parsing.one_of
    rows = (
        ("--env", "ENV", one_of("env", ENVS), "deepracer (the default), or backing: the Cyber "
         "Truck backs its trailer along paths"),
        ("--track", "TRACK", launching.resolve_track, "as of ./run lap (default)"),
        ("--observation", "O", _listed("observation", OBSERVATIONS), "state (place in the lane and "
         "motion; the default), lidar, camera; or several: state,camera"),
        ("--reward", "FILE", file, "a reward_function.py (default: progress)"),
        ("--metadata", "FILE", file, "a model_metadata.json: the actions"),
        ("--hyperparameters", "FILE", file, "a hyperparameters.json: of PPO"),
        ("--race", "RACE", one_of("race", RACES), f"one of {', '.join(RACES)}"),
        ("--randomize", "WHAT", _random, f"of {', '.join(RANDOM)}, separated by commas; or all, or "
         "nothing (default: start)"),
        ("--steps", "N", number("steps"), "actions in all (until all laps succeed)"),
        ("--workers", "N", number("workers"), "processes (twice the cores; for state 10 threads)"),
        ("--ray", "ADDRESS", _address, "workers as actors of Ray: auto (the cluster that this "
         "machine belongs to, or one of this machine alone), or HOST:PORT of the head"),
        ("--seed", "N", number("seed", 0), "of everything random (0)"),
    )  # fmt: skip
    parsing.add_options(parser, *((*row[:3], None, row[3]) for row in rows))
    for flag, default, text in (
        ("--walls", None, "walls along the lane, for the lidar"),
        ("--threads", None, "workers in threads of one process, on all cores, not in processes"),
        ("--tensorboard", None, "also a log for ./run exec tensorboard --logdir out/train"),
        ("--resume", False, "go on with what is in the folder"),
    ):
        parser.add_argument(flag, action="store_true", default=default, help=text)


def run(options, _rest):
    """Becomes the training."""
    from commands.bootstrap import venv

    environ = environment.ready()
    table = wanted(options)
    venv.prepare_extras("learning", *(name for name in ("ray", "tensorboard") if name in table))
    locks.take_results(table["folder"])
    words = ["paddock_gym.training.cli", json.dumps(table)]
    processes.become_module(VENV_PYTHON, words, environ)


def wanted(options):
    """Returns what the command line asks for: the Settings of the training, folder and resume."""
    table = {key: value for key, value in vars(options).items() if value is not None}
    if table.get("env") == "backing":
        for key in OF_THE_CAR:
            if key in table:
                raise UsageError(f"--{key} is an option of the DeepRacer; --env backing has none")
    if options.threads and options.ray:
        raise UsageError(f"ray is {options.ray!r}; with --threads there are no actors of Ray")
    if options.workers and options.workers > max_processes() and not options.threads:
        table.setdefault("ray", "auto")
    if not options.resume:
        observation = table.setdefault("observation", ["state"])
        backing = table.get("env") == "backing"
        kinds = ["backing"] if backing else observation
        if "steps" not in table and not backing and "ray" not in table:
            table["until_laps"] = True
        table.setdefault("steps", max(STEPS[name] for name in kinds))
        if not {"workers", "ray", "threads"} & set(table) and kinds == ["state"]:
            table["threads"] = True
        if table.get("threads"):
            table.setdefault("workers", WORLDS)
        table.setdefault("workers", 0 if "ray" in table else max_processes())
    elif "steps" in table:
        table["until_laps"] = False
    table["folder"] = os.path.join(OUT, "train", options.name)
    return table


def max_processes():
    """Returns how many workers are processes of this machine at most: twice its cores."""
    return 2 * len(os.sched_getaffinity(0))


def _address(value):
    if value != "auto" and not re.fullmatch(r"[A-Za-z0-9.-]+:[0-9]{1,5}", value):
        raise UsageError(f"ray is {value!r}; it must be auto, or HOST:PORT of a cluster's head")
    return value


def _listed(what, valid):
    def read(value):
        chosen = value.split(",")
        for name in chosen:
            if name not in valid:
                raise UsageError(f"{what} is {name!r}; there are {', '.join(valid)}")
        if len(set(chosen)) < len(chosen):
            raise UsageError(f"{what} is {value!r}; it must have each name once")
        return chosen

    read.complete = lambda: valid
    return read


def _random(value):
    chosen = value.split(",")
    if "all" not in chosen and "nothing" not in chosen:
        return _listed("randomize", (*RANDOM, "all", "nothing"))(value)
    if len(chosen) > 1:
        raise UsageError(f"randomize is {value!r}; all and nothing stand alone")
    return list(RANDOM) if value == "all" else []
