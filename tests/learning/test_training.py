"""Training itself: it learns, keeps what it has, goes on, survives dead workers."""

import csv
import io
import os
import pickle
import random
import signal
import time
import warnings
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.errors import GymError
from paddock_gym.policy.description import PolicyDescription
from paddock_gym.policy.onnx_policy import OnnxPolicy

import paddock_gym

EXAMPLES = Path(__file__).resolve().parents[2] / "src" / "paddock_gym" / "examples"
FILES = {
    "best_lap.mp4",
    "checkpoint.npz",
    "episodes.csv",
    "heat_map.png",
    "laps.png",
    "learning_curve.png",
    "policy.onnx",
    "progress.csv",
    "replay.html",
    "report.json",
    "settings.json",
}
SHORT = {"steps": 2048, "workers": 2}


@pytest.mark.parametrize(
    "options", [{}, {"observation": "lidar"}, {"observation": ("state", "camera")}]
)
def test_the_check_of_stable_baselines_has_no_complaint(options):
    from stable_baselines3.common.env_checker import check_env

    env = gymnasium.make(paddock_gym.IDS[0], **options)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    env.close()


def test_a_car_learns_to_drive_from_its_state(training):
    report = training.run(steps=20_480, workers=4)
    assert FILES <= {path.name for path in training.folder.iterdir()}
    assert report["steps"] == 20_480 and report["workers_lost"] == 0
    assert report["laps"] >= 9, report["ends"]
    assert report["mean_lap_time"] < report["track_length"] / 1.5  # [s]: 1.5 m/s and more


def test_a_training_ends_by_itself_as_soon_as_all_unseen_starts_are_laps(training):
    report = training.run(threads=True, workers=10, until_laps=True)
    assert report["until_laps"] and not report["interrupted"]
    assert report["laps"] == report["evaluated_starts"] == 10, report["ends"]
    assert report["steps"] < 15_000
    assert (
        training.run(resume=True, until_laps=False, steps=report["steps"] + 640)["steps"]
        > (report["steps"])
    )


def test_threads_give_what_environments_one_after_the_other_give():
    from paddock_gym.training.worker import make
    from paddock_gym.training.workers import Threads
    from stable_baselines3.common.vec_env import DummyVecEnv

    count, rng = 3, np.random.default_rng(2)
    actions = rng.uniform(-1.0, 1.0, (50, count, 2)).astype(np.float32)
    together = Threads({"observation": ("state", "lidar")}, count)
    alone = DummyVecEnv([lambda: make({"observation": ("state", "lidar")})] * count)
    for env in (together, alone):
        env.seed(5)
    one, other, ends = together.reset(), alone.reset(), 0
    for row in actions:
        assert all((one[name] == other[name]).all() for name in ("state", "lidar"))
        one, rewards, dones, infos = together.step(row)
        other, *expected = alone.step(row)
        assert (rewards == expected[0]).all() and (dones == expected[1]).all()
        for mine, its, done in zip(infos, expected[2], dones):
            assert mine["TimeLimit.truncated"] == its["TimeLimit.truncated"]
            assert ("episode" in mine) == ("terminal_observation" in mine) == done
            assert mine["end"] == its["end"] and mine["x"] == its["x"]
        ends += dones.sum()
    assert ends >= 2
    assert together.env_method("reset", indices=[1])[0][1]["end"] == ""
    assert together.get_attr("render_mode") == [None] * count
    together.close(), alone.close()


def test_a_training_in_threads(training):
    report = training.run(threads=True, **SHORT)
    assert report["steps"] == 2048 and report["workers_lost"] == 0
    assert len(report["ends"]) == report["evaluated_starts"] == 10
    assert training.run(resume=True, threads=True, steps=3072)["steps"] == 3072


@pytest.mark.parametrize("reward", ["centre_line", "waypoints", "fewer_steps"])
def test_rewards_in_a_published_style_train_as_they_are(training, reward):
    report = training.run(
        reward=str(EXAMPLES / f"{reward}.py"),
        metadata=str(EXAMPLES / "model_metadata.json"),
        hyperparameters=str(EXAMPLES / "hyperparameters.json"),
        **SHORT,
    )
    assert 2048 <= report["steps"] < 4096  # whole runs up to the update after the last step
    assert 0 < len((training.folder / "episodes.csv").read_text().splitlines())


def test_tensorboard_shows_what_the_table_has(training):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    training.run(tensorboard=True, **SHORT)
    log = EventAccumulator(str(training.folder))
    log.Reload()
    with open(training.folder / "progress.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    names = set(log.Tags()["scalars"])
    assert {"rollout/ep_rew_mean", "train/loss"} <= names <= set(rows[0])
    for name in names:
        shown = [event.value for event in log.Scalars(name)]
        assert shown == pytest.approx([float(row[name]) for row in rows if row[name]], rel=1e-5)


class Command:
    """Makes a folder when it is unpickled."""

    def __init__(self, folder):
        self._folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self._folder),)


def small_model(seed):
    from stable_baselines3 import PPO

    return PPO("MlpPolicy", "Pendulum-v1", n_steps=64, batch_size=32, device="cpu", seed=seed)


def test_nothing_of_a_folder_from_elsewhere_is_executed(tmp_path):
    """A checkpoint was a pickle, which executes what it says."""
    from paddock_gym.training import checkpoint

    model, path, sign = small_model(1), tmp_path / "checkpoint.npz", tmp_path / "executed"
    checkpoint.save(model, str(path))
    whole, stream = path.read_bytes(), io.BytesIO()
    np.savez(stream, about=np.array([Command(sign)], object))
    for content in (stream.getvalue(), pickle.dumps(Command(sign)), whole[:2000], b"", b"PK"):
        path.write_bytes(content)
        with pytest.raises(GymError, match="checkpoint.npz cannot be read"):
            checkpoint.restore(model, str(path))
        assert not sign.exists()
    path.rename(tmp_path / "checkpoint.zip")
    with pytest.raises(GymError, match="is of an earlier version and is not read"):
        checkpoint.restore(model, str(path))


def test_a_training_continues_with_the_same_numbers(tmp_path):
    """Saved and restored into a new model: weights, optimizer, counters, random states."""
    import torch
    from paddock_gym.training import checkpoint

    one, path = small_model(1), tmp_path / "checkpoint.npz"
    one.learn(128)
    checkpoint.save(one, str(path))
    drawn = np.random.rand(), random.random(), torch.rand(1).item()
    other = small_model(2)
    checkpoint.restore(other, str(path))
    assert (np.random.rand(), random.random(), torch.rand(1).item()) == drawn
    assert other.num_timesteps == 128 and other._n_updates == one._n_updates
    for mine, its in zip(one.policy.parameters(), other.policy.parameters()):
        assert torch.equal(mine, its)
    before, after = (each.policy.optimizer.state_dict()["state"] for each in (one, other))
    assert before.keys() == after.keys()
    for number, values in before.items():
        assert all(torch.equal(value, after[number][key]) for key, value in values.items())


def test_ctrl_c_keeps_everything_and_resume_goes_on(training):
    process = training.start(steps=200_000, workers=2)
    training.wait_for(process, " steps, ")
    process.send_signal(signal.SIGINT)
    output = process.communicate(timeout=300.0)[0]
    assert process.returncode == 0, output
    first = training.report()
    assert first["interrupted"] and 0 < first["steps"] < 200_000
    assert FILES <= {path.name for path in training.folder.iterdir()}
    more = training.run(resume=True, steps=first["steps"] + 1024)
    assert more["steps_this_time"] >= 1024
    assert more["steps"] == first["steps"] + more["steps_this_time"]
    refused = training.start(resume=True, track="hard")
    output, _ = refused.communicate(timeout=100.0)
    assert refused.returncode == 1
    assert "track is 'hard', but test was trained with 'default'" in output


def test_a_killed_worker_costs_its_run_only(training):
    process = training.start(steps=6144, workers=2)
    time.sleep(0.5)
    training.wait_for(process, " steps, ")
    os.kill(_workers(process.pid)[0], signal.SIGKILL)
    output = process.communicate(timeout=300.0)[0]
    assert process.returncode == 0, output
    assert "a worker died and was replaced" in output
    report = training.report()
    assert (report["steps"], report["workers_lost"]) == (6144, 1)


def _workers(parent):
    """Processes of the environments: those below the server that forks them."""
    import psutil

    found = [
        child
        for child in psutil.Process(parent).children(recursive=True)
        if "forkserver" in " ".join(child.cmdline()) and child.ppid() != parent
    ]
    return [child.pid for child in found]


def test_errors_of_a_reward_end_the_training_with_their_traceback(training, tmp_path):
    path = tmp_path / "reward_function.py"
    path.write_text(
        "def reward_function(params):\n"
        "    return 1.0 if params['steps'] < 5 else params['nothing']\n"
    )
    process = training.start(reward=str(path), **SHORT)
    output, _ = process.communicate(timeout=300.0)
    assert process.returncode == 1
    assert "line 2, in reward_function" in output and "KeyError: 'nothing'" in output
    assert "'steps': 5" in output


@pytest.mark.parametrize(
    "options",
    [
        {"observation": "state"},
        {"observation": "camera", "action": str(EXAMPLES / "model_metadata.json")},
        {"observation": ("state", "lidar"), "walls": True},
    ],
)
def test_a_file_decides_as_its_network(options, tmp_path):
    from paddock_gym.policy.export import export
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import DummyVecEnv

    env = DeepRacerEnv(**options)
    kind = {"state": "MlpPolicy", "camera": "CnnPolicy"}.get(
        options["observation"], "MultiInputPolicy"
    )
    model = PPO(kind, DummyVecEnv([lambda: env]), seed=3, device="cpu")
    about = PolicyDescription(env.options.observations, False, env.options.actions, 15.0, "default")
    path = str(tmp_path / "policy.onnx")
    export(model.policy, env.observation_space, about, path)
    policy = OnnxPolicy(path)
    assert policy.description == about
    observation, _ = env.reset(seed=1)
    for _ in range(10):
        expected, _ = model.predict(observation, deterministic=True)
        action = policy.act(observation)
        assert np.asarray(action) == pytest.approx(np.clip(expected, -1.0, 1.0), abs=1e-5) or (
            action == expected
        )
        observation, *_ = env.step(action)
    env.close()


def test_updates_come_after_as_many_runs_as_the_hyperparameters_say(training, tmp_path):
    path = tmp_path / "hyperparameters.json"
    path.write_text('{"num_episodes_between_training": 30, "batch_size": 32, "num_epochs": 1}')
    training.run(hyperparameters=str(path), steps=6144, workers=2)
    rows = (training.folder / "episodes.csv").read_text().splitlines()
    logged = (training.folder / "progress.csv").read_text().splitlines()
    updates = len(logged) - 1
    column = logged[0].split(",").index("time/total_timesteps")
    first = int(logged[1].split(",")[column])
    assert first == 1024  # nothing is known of the length of a run yet
    later = [int(row.split(",")[0]) for row in rows[1:]]
    runs = sum(step > first for step in later) / (updates - 1)
    assert 20 < runs < 45


def test_backing_trains_and_goes_on(training):
    report = training.run(env="backing", steps=1024, workers=2)
    assert report["steps"] == 1024 and len(report["ends"]) == report["evaluated_starts"] == 10
    assert report["arrived"] == report["ends"].count("arrived")
    about = OnnxPolicy(str(training.folder / "policy.onnx"), env="backing").description
    assert about.env == "backing" and about.actions.speed == (-0.4, 0.4)
    assert (training.folder / "learning_curve.png").is_file()
    assert training.run(resume=True, steps=2048)["steps"] == 2048
