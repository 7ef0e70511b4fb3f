"""One training from its settings to its files."""

import dataclasses
import json
import os
import time

import torch
from paddock_common.process import StopRequest
from stable_baselines3.common.logger import configure

from paddock_gym.training import algorithm, checkpoint
from paddock_gym.training.algorithm import Features
from paddock_gym.training.finish import STARTS, finish, success
from paddock_gym.training.watch import Watch
from paddock_gym.training.workers import Workers, factory

REPORT = "report.json"
INITIAL_DEVIATION = -0.7  # logarithm of the standard deviation of the first actions


def train(settings, folder, resume=False, say=print, ray=None):
    """Train, and write everything into the folder, also after Ctrl-C.

    Args:
        settings: Settings.
        folder: exists, with settings.json.
        resume: go on from its checkpoint.
        say: function of one line.
        ray: address of a Ray cluster (auto, HOST:PORT) for the workers; None: processes here.

    Returns:
        The report, a dict.
    """
    # Small networks are fastest on one thread; those for pictures learn while the workers wait.
    torch.set_num_threads(len(os.sched_getaffinity(0)) if "camera" in settings.observation else 1)
    settings, workers = _workers(settings, folder, ray, say)
    begin = time.monotonic()
    try:
        model = _model(settings, folder, workers, resume)
        already = model.num_timesteps
        model.set_logger(configure(folder, ["csv"]))
        with StopRequest() as stop:  # Ctrl-C ends the training in order
            watch = Watch(folder, settings.steps, say, stop.requested, *success(settings))
            model.learn(
                max(0, settings.steps - already), callback=watch, reset_num_timesteps=not resume
            )
        checkpoint.save(model, folder)
        seconds = time.monotonic() - begin
        lost = workers.lost
    finally:
        workers.close()
    say(f"train: {model.num_timesteps} steps done, now runs from {STARTS} unseen starts")
    report = {
        "settings": vars(settings),
        "steps": model.num_timesteps,
        "steps_this_time": model.num_timesteps - already,
        "seconds_this_time": round(seconds, 1),
        "interrupted": stop.requested(),
        "workers_lost": lost,
        **finish(settings, folder, model),
    }
    with open(os.path.join(folder, REPORT), "w", encoding="utf-8") as stream:
        json.dump(report, stream, indent=2)
        stream.write("\n")
    return report


def _workers(settings, folder, address, say):
    """(settings with the number of workers, the workers)."""
    if not address:
        return settings, Workers([factory(settings.environment())] * settings.workers)
    from paddock_gym.training import ray_actors

    nodes = ray_actors.connect(address, say)
    if not settings.workers:
        settings = dataclasses.replace(settings, workers=max(1, int(sum(nodes))))
        settings.save(folder)
    gamma = settings.algorithm()["gamma"]
    return settings, ray_actors.RayWorkers(settings.environment(), settings.workers, nodes, gamma)


def _model(settings, folder, workers, resume):
    """The PPO of a training, new or from its checkpoint."""
    if resume:
        model = algorithm.of(settings, workers).load(
            os.path.join(folder, checkpoint.FILE), env=workers, device="cpu"
        )
        workers.seed(settings.seed + model.num_timesteps)  # other starts than at the beginning
        checkpoint.restore_numbers(folder)
        return model
    kinds = settings.observation
    network = {
        "log_std_init": INITIAL_DEVIATION,
        "features_extractor_class": Features,
        "net_arch": [64, 64],
    }
    policy = "CnnPolicy" if kinds == ("camera",) else "MlpPolicy"
    if len(kinds) > 1:
        policy = "MultiInputPolicy"
    arguments = settings.algorithm()
    return algorithm.of(settings, workers)(
        policy, workers, seed=settings.seed, device="cpu", policy_kwargs=network, **arguments
    )
