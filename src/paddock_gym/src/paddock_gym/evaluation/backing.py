"""Backing to goals in the gym: policies and the tracker."""

import math
from dataclasses import dataclass

import numpy as np
from cybertruck.trailer.steering import IdealSteering
from cybertruck.trailer.tracker import Tracker, Tuning

from paddock_gym.envs.backing import ARRIVED, TOP_SPEED, BackingEnv
from paddock_gym.evaluation.laps import FIRST_SEED, PolicyDriver
from paddock_gym.ids import BACKING


class TrackerDriver:
    """Backs by the law of cybertruck.trailer.tracker."""

    def __init__(self):
        self._tracker = None

    def restart(self):
        """Start a new path."""
        self._tracker = None

    def act(self, _observation, env):
        """The action at the truck's pose."""
        geometry = env.task.truck.geometry
        if self._tracker is None:
            steering = IdealSteering(geometry.wheelbase, geometry.max_steering)
            self._tracker = Tracker(env.task.path, geometry, steering, Tuning())
        status = self._tracker.step(
            *env.task.truck.trailer_axle_pose(), env.task.truck.hitch_angle()
        )
        return np.array(
            (float(status.steering) / geometry.max_steering, float(status.speed) / TOP_SPEED),
            np.float32,
        )


HEAD = (
    "driver", "arrived", "time [s]", "lateral error, rms [cm]", "lateral error at the end [cm]",
    "heading error at the end [degrees]", "other ends",
)  # fmt: skip


@dataclass(frozen=True)
class BackingRun:
    """One start.

    Attributes:
        end: arrived, jackknifed, lost, or empty: truncated.
        time: simulated [s].
        lateral, heading: errors at the end [m], [rad].
        rms_lateral: distance from the path during the run, the start's offset included [m].
    """

    end: str
    time: float
    lateral: float
    heading: float
    rms_lateral: float


def drive(env: BackingEnv, driver, seed, after_action=None) -> BackingRun:
    """Drive once along the path of a seed.

    Args:
        driver: has act(observation, env) -> action, and restart().
        seed: of path and start.
        after_action: called without arguments.
    """
    observation, info = env.reset(seed=seed)
    driver.restart()
    lateral, done = [], False
    while not done:
        observation, _, terminated, truncated, info = env.step(driver.act(observation, env))
        done = terminated or truncated
        lateral.append(info["lateral"])
        if after_action:
            after_action()
    rms = float(np.sqrt(np.mean(np.square(lateral))))
    return BackingRun(info["end"], info["time"], info["lateral"], info["heading"], rms)


def runs(env, driver, count):
    """Runs from the first of the unseen starts, the same for every driver."""
    return [drive(env, driver, FIRST_SEED + k) for k in range(count)]


def compare(policy, count):
    """Rows (dicts) of a policy and of the tracker."""
    env = BackingEnv()
    drivers = {"policy": PolicyDriver(policy, BACKING), "tracker": TrackerDriver()}
    rows = [summary(name, runs(env, driver, count)) for name, driver in drivers.items()]
    env.close()
    return rows


def summary(driver, driven):
    """Report of a driver's runs; errors and times are of those that arrived."""
    arrived = [run for run in driven if run.end == ARRIVED]
    return {
        "driver": driver,
        "starts": len(driven),
        "arrived": len(arrived),
        "times": [round(run.time, 3) for run in arrived],
        "rms_lateral": [round(run.rms_lateral, 5) for run in arrived],
        "end_lateral": [round(abs(run.lateral), 5) for run in arrived],
        "end_heading": [round(math.degrees(abs(run.heading)), 3) for run in arrived],
        "other_ends": [run.end or "too slow" for run in driven if run.end != ARRIVED],
    }


def lines(rows):
    """Cells of the table of rows, with its head: medians and largest values."""
    table = [HEAD]
    for row in rows:
        table.append(
            (
                row["driver"],
                f"{row['arrived']} of {row['starts']}",
                _spread(row["times"]),
                _spread(row["rms_lateral"], 100.0),
                _spread(row["end_lateral"], 100.0),
                _spread(row["end_heading"]),
                ", ".join(sorted(set(row["other_ends"]))) or "-",
            )
        )
    return table


def _spread(values, scale=1.0):
    if not values:
        return "-"
    return f"{scale * np.median(values):.1f}, at most {scale * max(values):.1f}"
