"""Drives in the gym as replays."""

import array
import base64
import json
import re
import sys

import pytest
from paddock_gym.evaluation.laps import PursuitDriver, drive
from paddock_gym.evaluation.replays import keep

ACTIONS = 12


@pytest.fixture
def lap(env):
    """Some actions of a drive, as keep() wants it; `places` are those of the car."""

    def some(add_frame):
        env.reset(seed=1, options={"start": 0.1, "lateral": 0.0, "turn": 0.0})
        driver = PursuitDriver(1.0)
        for _ in range(ACTIONS):
            env.step(driver.act(None, env))
            some.places.append((env.task.motion.x, env.task.motion.y))
            add_frame()
        return "twelve actions"

    some.places = []
    return some


def test_a_drive_becomes_a_page_with_its_frames(env, lap, tmp_path):
    path = tmp_path / "replay.html"
    assert keep(env.world.world, "first: the best lap", str(path), lap) == ""
    assert path.stat().st_size < 10_000_000
    data = json.loads(re.search(r"window\.REPLAY = (.*?);</script>", path.read_text())[1])
    assert (data["title"], data["text"]) == ("first: the best lap", "twelve actions")
    (part,) = data["parts"]
    times = array.array("d", base64.b64decode(part["times"]))
    assert len(times) == ACTIONS
    assert times[-1] - times[0] == pytest.approx((ACTIONS - 1) / 15.0, abs=1e-3)  # whole steps
    names = {body["key"]: body["name"] for body in part["scene"]["bodies"]}
    key, width = next(row for row in part["bodies"] if names[row[0]] == "racecar")
    rows = array.array("f", base64.b64decode(part["rows"]))
    offset = 0
    for other, count in part["bodies"]:
        if other == key:
            break
        offset += count
    whole = sum(count for _, count in part["bodies"])
    driven = [(rows[k * whole + offset], rows[k * whole + offset + 1]) for k in range(ACTIONS)]
    assert width > 7
    for (x, y), place in zip(driven, lap.places):
        assert (x, y) == pytest.approx(place, abs=1e-4)


def test_a_drive_goes_on_without_bullet_web(env, lap, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "bullet_web.replay", None)
    reason = keep(env.world.world, "t", str(tmp_path / "replay.html"), lap)
    assert "bullet_web.replay" in reason
    assert len(lap.places) == ACTIONS and list(tmp_path.iterdir()) == []


def test_a_replay_that_cannot_be_written_is_told(env, lap, tmp_path):
    reason = keep(env.world.world, "t", str(tmp_path / "none" / "replay.html"), lap)
    assert "No such file" in reason and len(lap.places) == ACTIONS


def test_the_best_lap_is_driven_as_before(env, lap):
    def end(add_frame):
        done = drive(
            env,
            PursuitDriver(1.0),
            {"start": 0.1, "lateral": 0.0, "turn": 0.0},
            after_action=add_frame,
        )
        return done.end, done.time, done.trajectory.tolist()

    watched = []
    assert end(None) == end(lambda: watched.append(1)) and watched
