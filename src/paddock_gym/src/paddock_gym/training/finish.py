"""The end of a training: the better of two policies, its report and its plots."""

import os

import numpy as np

from paddock_gym.contract.actions import Continuous
from paddock_gym.course import LAP
from paddock_gym.envs.backing import ARRIVED, TOP_SPEED, BackingEnv
from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.evaluation import backing, plots, replays
from paddock_gym.evaluation.laps import FIRST_SEED, PolicyDriver, drive, film_lap, starts
from paddock_gym.ids import BACKING
from paddock_gym.policy.description import PolicyDescription
from paddock_gym.policy.export import export
from paddock_gym.training import checkpoint, monitor
from paddock_gym.training.examination import STARTS

POLICY, FILM, REPLAY = "policy.onnx", "best_lap.mp4", "replay.html"


def success(settings):
    """(end of a successful run, noun for several) of a training's environment."""
    return (ARRIVED, "arrivals") if settings.env == BACKING else (LAP, "laps")


def finish(settings, folder, model):
    """Write the better policy, its evaluation and plots; returns its part of the report.

    Args:
        model: PPO as it is after the last step; the best one so far is in best.npz.
    """
    work = _finish_backing if settings.env == BACKING else _finish_laps
    rows = monitor.episodes(folder)
    curve = os.path.join(folder, "learning_curve.png")
    monitor.learning_curve(rows, curve, *success(settings))
    return work(settings, folder, model, rows)


def _finish_laps(settings, folder, model, rows):
    options = settings.environment()
    del options["id"]
    env = DeepRacerEnv(**options)
    description = PolicyDescription(
        settings.observation,
        settings.colour,
        env.options.actions,
        1.0 / env.period,
        settings.track,
        settings.race,
    )

    def evaluate(path):
        driver = PolicyDriver(path)
        laps = [drive(env, driver, start, seed=k) for k, start in enumerate(starts(STARTS))]
        return (sum(lap.is_lap for lap in laps), -np.mean([lap.time for lap in laps])), laps

    laps = _write_better(folder, model, env, description, evaluate)
    monitor.heat_map(rows, env.task.track, os.path.join(folder, "heat_map.png"))
    plots.paths(laps, env.task.track, os.path.join(folder, "laps.png"))
    complete = [lap for lap in laps if lap.is_lap]
    times = [lap.time for lap in complete]
    best = min(complete or laps, key=lambda lap: (-lap.progress, lap.time))
    filmed, driver = starts(STARTS)[laps.index(best)], PolicyDriver(os.path.join(folder, POLICY))

    def drive_best(add_frame):
        lap = film_lap(env, driver, filmed, os.path.join(folder, FILM), add_frame)
        return f"{lap.end}, {lap.progress:.0f} % of a lap in {lap.time:.2f} s"

    replay = os.path.join(folder, REPLAY)
    problem = replays.keep(env.world.world, f"{settings.name}: the best lap", replay, drive_best)
    env.close()
    return {
        **_without_replay(problem),
        "track_length": round(float(env.task.course.length), 3),
        "evaluated_starts": STARTS,
        "laps": len(complete),
        "lap_times": [round(seconds, 3) for seconds in times],
        "mean_lap_time": round(float(np.mean(times)), 3) if times else None,
        "ends": [lap.end for lap in laps],
    }


def _finish_backing(settings, folder, model, _rows):
    env = BackingEnv()
    steering = float(np.degrees(env.task.truck.geometry.max_steering))
    actions = Continuous((-steering, steering), (-TOP_SPEED, TOP_SPEED))
    rate = 1.0 / env.period
    description = PolicyDescription(settings.observation, False, actions, rate, "", "", env=BACKING)

    def evaluate(path):
        runs = backing.runs(env, PolicyDriver(path, BACKING), STARTS)
        arrived = sum(run.end == ARRIVED for run in runs)
        return (arrived, -np.mean([run.rms_lateral for run in runs])), runs

    runs = _write_better(folder, model, env, description, evaluate)
    best = min(range(STARTS), key=lambda k: (runs[k].end != ARRIVED, runs[k].rms_lateral))
    driver = PolicyDriver(os.path.join(folder, POLICY), BACKING)

    def drive_best(add_frame):
        run = backing.drive(env, driver, FIRST_SEED + best, add_frame)
        return f"{run.end or 'too slow'} after {run.time:.1f} s, {100 * run.rms_lateral:.1f} cm rms"

    replay = os.path.join(folder, REPLAY)
    problem = replays.keep(env.world.world, f"{settings.name}: the best run", replay, drive_best)
    env.close()
    row = backing.summary("policy", runs)
    return {
        **_without_replay(problem),
        "evaluated_starts": row.pop("starts"),
        **row,
        "ends": [run.end for run in runs],
    }


def _without_replay(problem):
    """The report's part on a replay that could not be written; none otherwise."""
    return {"no_replay": problem} if problem else {}


def _write_better(folder, model, env, description, evaluate):
    """Write the better of the last and the best policy as POLICY; returns its runs.

    The model's policy is the best one afterwards, where there is one.

    Args:
        evaluate: function of a policy's path: (score, runs).
    """
    best = os.path.join(folder, monitor.BEST)
    candidates = ["last", "best"] if os.path.exists(best) else ["last"]
    better = None
    for name in candidates:
        if name == "best":
            checkpoint.load_policy(model.policy, best)  # the last one's file is complete
        path = os.path.join(folder, f"{name}.onnx")
        export(model.policy, env.observation_space, description, path)
        score, runs = evaluate(path)
        if better is None or score > better[0]:
            better = score, path, runs
    os.replace(better[1], os.path.join(folder, POLICY))
    for name in candidates:
        path = os.path.join(folder, f"{name}.onnx")
        if os.path.exists(path):
            os.remove(path)
    return better[2]
