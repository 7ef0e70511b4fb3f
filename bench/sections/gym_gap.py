"""The same lap by the same policy in the gym and over ROS, for each observation.

Policies are those of ./run train with its defaults (lidar: between walls); out/bench/policies/
keeps them, and what it lacks is trained first. A lap goes from line to line after a standing start;
in the gym it is the same each time, over ROS messages may come at other moments.
"""

import argparse
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from figures import BenchError, Spread
from launching import Graph
from report import Row

from commands.paths import OUT
from commands.subcommands import lap, train

# Observation -> (options of the training, real-time factor of the lap: images take time).
KINDS = {"state": ({}, 0.5), "lidar": ({"walls": True}, 0.5), "camera": ({}, 0.2)}
LAPS = 3  # over ROS
FOLDER = pathlib.Path(OUT, "bench", "policies")
LIMIT = 600.0  # of a lap over ROS, wall time [s]


def policy_of(name, log):
    """Path of an observation's policy, which is trained if there is none.

    Raises:
        BenchError: the training failed, or ./run train has not installed its packages.
    """
    folder = FOLDER / name
    if not (folder / "policy.onnx").exists():
        if not importlib.util.find_spec("stable_baselines3"):
            raise BenchError("there is no policy; ./run train installs what trains one")
        words = [sys.executable, "-m", "paddock_gym.training.cli", json.dumps(training(name))]
        if subprocess.run(words, stdout=log, stderr=log, check=False).returncode:
            raise BenchError("the training failed")
    return folder / "policy.onnx"


def training(name):
    """What ./run train asks for with an observation, and the folder."""
    given = dict.fromkeys(("threads", "ray", "workers"))
    given.update(name=name, observation=[name], resume=False, **KINDS[name][0])
    return {**train.wanted(argparse.Namespace(**given)), "folder": str(FOLDER / name)}


def lap_in_the_gym(policy):
    """Time [s] of a lap.

    Raises:
        BenchError: no lap came of it.
    """
    from paddock_gym.envs.deepracer import DeepRacerEnv
    from paddock_gym.evaluation.laps import PolicyDriver, line_to_line
    from paddock_gym.training.settings import Settings

    options = Settings.load(policy.parent).environment()
    del options["id"]
    env = DeepRacerEnv(**options)
    try:
        seconds = line_to_line(env, PolicyDriver(str(policy)))
    finally:
        env.close()
    if seconds is None:
        raise BenchError("in the gym no lap came of it")
    return seconds


def lap_over_ros(policy, factor, log):
    """Time [s] of a lap as of ./run lap.

    Args:
        factor: real-time factor.

    Raises:
        BenchError: no lap came of it.
    """
    options = argparse.Namespace(driver="policy", policy=str(policy))
    graph = Graph(log)
    with tempfile.TemporaryDirectory() as folder:
        arguments = [
            f"out_dir:={folder}", "driver:=policy", "replay:=false",
            f"real_time_factor:={factor}", *lap.policy_arguments(options),
        ]  # fmt: skip
        words = ["roslaunch", "-p", str(graph.port), "deepracer_teleop", "lap.launch", *arguments]
        try:
            graph.popen(*words).wait(LIMIT)
        except subprocess.TimeoutExpired:
            raise BenchError(f"over ROS there was no lap within {LIMIT:g} s") from None
        finally:
            graph.close()
        return lap_time(os.path.join(folder, "result.json"))


def lap_time(path):
    """Time [s] of the lap that a result.json tells of.

    Raises:
        BenchError: it tells of none.
    """
    try:
        with open(path, encoding="utf-8") as stream:
            (start,) = json.load(stream)["starts"]
    except (OSError, ValueError, KeyError) as error:
        raise BenchError(f"over ROS there was no result: {error}") from None
    if start["outcome"] != "lap":
        raise BenchError(f"over ROS no lap came of it: {start['outcome']}")
    return start["lap_time"]


def measure(quick, log):
    """Laps of each observation; quick: one, of the state."""
    found, errors = {}, {}
    for name in list(KINDS)[:1] if quick else KINDS:
        try:
            policy = policy_of(name, log)
            laps = [lap_over_ros(policy, KINDS[name][1], log) for _ in range(1 if quick else LAPS)]
            found[name] = {"gym": lap_in_the_gym(policy), "ros": laps}
        except BenchError as error:
            errors[name] = str(error)
    return {**found, "errors": errors}


def rows(figures):
    """Of each observation: both laps, and what the second takes more."""
    for name in KINDS:
        if name not in figures:
            continue
        gym, ros = figures[name]["gym"], Spread.of(figures[name]["ros"])
        more = Spread.of(100.0 * (seconds / gym - 1.0) for seconds in figures[name]["ros"])
        yield Row(f"{name}, lap in the gym", f"{gym:.2f} s", gym, "s")
        yield Row(f"{name}, lap over ROS", f"{ros.text()} s", ros, "s")
        yield Row(f"{name}, over ROS longer by", f"{more.text('+.2f')} %", more, "%")
