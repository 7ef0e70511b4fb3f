"""One training from its settings to its files."""

import dataclasses
import importlib.util
import os
import time

import torch
from paddock_common.process import StopRequest
from stable_baselines3.common.logger import configure

from paddock_gym.contract.hyperparameters import write_json
from paddock_gym.errors import GymError
from paddock_gym.training import algorithm, checkpoint
from paddock_gym.training.algorithm import Features
from paddock_gym.training.examination import STARTS
from paddock_gym.training.finish import finish, success
from paddock_gym.training.monitor import TrainingMonitor
from paddock_gym.training.workers import Threads, Workers, factory

REPORT = "report.json"
INITIAL_DEVIATION = -0.7  # logarithm of the standard deviation of the first actions


def train(settings, folder, resume=False, log=print, ray=None):
    """Train, and write everything into the folder, also after Ctrl-C.

    Args:
        folder: exists, with settings.json.
        resume: continue from its checkpoint.
        log: function of one line.
        ray: address of a Ray cluster (auto, HOST:PORT) for the workers; None: processes here.

    Returns:
        The report, a dict.

    Raises:
        GymError: the settings want a log for TensorBoard, which is not installed.
    """
    # Small networks are fastest on one thread; those for images learn while the workers wait.
    torch.set_num_threads(len(os.sched_getaffinity(0)) if "camera" in settings.observation else 1)
    logs = _logs(settings)
    settings, workers = _workers(settings, folder, ray, log)
    started_at = time.monotonic()
    try:
        model = _model(settings, folder, workers, resume)
        already = model.num_timesteps
        model.set_logger(configure(folder, logs))
        with StopRequest() as stop:  # Ctrl-C stops the training cleanly
            monitor = TrainingMonitor(
                folder, settings.steps, log, stop.requested, *success(settings),
                settings.until_laps,
            )  # fmt: skip
            model.learn(
                max(0, settings.steps - already), callback=monitor, reset_num_timesteps=not resume
            )
        checkpoint.save(model, os.path.join(folder, checkpoint.FILE))
        seconds = time.monotonic() - started_at
        lost = workers.lost
    finally:
        workers.close()
    log(f"train: {model.num_timesteps} steps done, now runs from {STARTS} unseen starts")
    report = {
        "settings": vars(settings),
        "steps": model.num_timesteps,
        "steps_this_time": model.num_timesteps - already,
        "seconds_this_time": round(seconds, 1),
        "interrupted": stop.requested(),
        "until_laps": monitor.passed,
        "workers_lost": lost,
        **finish(settings, folder, model),
    }
    write_json(os.path.join(folder, REPORT), report)
    return report


def _logs(settings):
    """Kinds of logs that stable-baselines3 writes."""
    if not settings.tensorboard:
        return ["csv"]
    if not importlib.util.find_spec("tensorboard"):
        raise GymError("tensorboard is True, but not installed; pip install tensorboard")
    return ["csv", "tensorboard"]


def _workers(settings, folder, address, log):
    """(settings with the number of workers, the workers)."""
    if settings.threads:
        return settings, Threads(settings.environment(), settings.workers)
    if not address:
        return settings, Workers([factory(settings.environment())] * settings.workers)
    from paddock_gym.training import ray_actors

    nodes = ray_actors.connect(address, log)
    if not settings.workers:
        settings = dataclasses.replace(settings, workers=max(1, int(sum(nodes))))
        settings.save(folder)
    gamma = settings.algorithm()["gamma"]
    return settings, ray_actors.RayWorkers(settings.environment(), settings.workers, nodes, gamma)


def _model(settings, folder, workers, resume):
    """The PPO of a training, new or from its checkpoint."""
    names = settings.observation
    network = {
        "log_std_init": INITIAL_DEVIATION,
        "features_extractor_class": Features,
        "net_arch": [64, 64],
    }
    policy = "CnnPolicy" if names == ("camera",) else "MlpPolicy"
    if len(names) > 1:
        policy = "MultiInputPolicy"
    arguments = settings.algorithm(not isinstance(workers, (Threads, Workers)))
    model = algorithm.of(settings, workers)(
        policy, workers, seed=settings.seed, device="cpu", policy_kwargs=network, **arguments
    )
    if resume:
        checkpoint.restore(model, os.path.join(folder, checkpoint.FILE))
        workers.seed(settings.seed + model.num_timesteps)  # other starts than those until then
    return model
