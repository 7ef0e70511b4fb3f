"""bench/paths_beside_gazebo.py: figures of paths, the record, the page, bad input."""

import json
import math
import sys
from pathlib import Path

import cv2
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))

import paths_beside_gazebo as command  # noqa: E402


def circle(speed=0.5, rate=0.8, seconds=4.0, period=0.02):
    """Rows of a circle."""
    rows = []
    for step in range(round(seconds / period) + 1):
        t = step * period
        yaw = rate * t
        x, y = speed / rate * math.sin(yaw), speed / rate * (1 - math.cos(yaw))
        rows.append([10 + t, x, y, (yaw + math.pi) % (2 * math.pi) - math.pi])
    return rows


def write(folder, name, **sides):
    """Recordings of a package."""
    for side, paths in sides.items():
        (folder / f"{name}.{side}.json").write_text(json.dumps({"paths": paths}))


def test_a_recording_is_taken_and_drawn(tmp_path, monkeypatch):
    for name, value in (("RECORD", "r.json"), ("PAGE", "docs/beside-gazebo.md"), ("ROOT", "")):
        monkeypatch.setattr(command, name, tmp_path / value)
    public = {"robot": "Bot", "address": "https://github.com/a/b", "branch": "c", "launch": "d"}
    monkeypatch.setattr(command, "packages", lambda: {"bot": public})
    (tmp_path / "docs" / "images").mkdir(parents=True)
    drives = {"turn": circle(), "stop": circle(speed=0.1)}
    write(tmp_path, "bot", gazebo=drives, paddock=dict(drives, turn=circle(speed=0.6)))
    write(tmp_path, "car", gazebo=drives, paddock=drives)
    assert command.main(["--update", str(tmp_path)]) == 0
    text = (tmp_path / "docs" / "beside-gazebo.md").read_text()
    assert "**0 of 1 driven phases of 1 launch files from 1 public repositories" in text
    assert "| public, driven | 1 | 1 | 0 | 1 | 0 |" in text
    assert "| Paddock's own, driven | 1 | 1 | 1 | 0 | 0 |" in text
    assert "| bot | turn | 0.499, 0.800 | 0.599, 0.800 | no |" in text
    assert "| car | turn | 0.499, 0.800 | 0.499, 0.800 | yes |" in text
    for kind in ("paths", "speeds", "yaw_rates"):
        image = cv2.imread(str(tmp_path / "docs" / "images" / f"all_{kind}.png"))
        blue = (abs(image.astype(int) - (143, 111, 47)).max(axis=2) < 40).sum()
        orange = (abs(image.astype(int) - (30, 84, 179)).max(axis=2) < 40).sum()
        assert blue > 100 and orange > 100
    # a package that a folder does not have stays
    (tmp_path / "more").mkdir()
    write(tmp_path / "more", "bot", gazebo=drives, paddock=drives)
    assert command.main(["--update", str(tmp_path / "more")]) == 0
    assert set(command.recorded()) == {"bot", "car"}


def test_further_runs_are_taken(tmp_path, monkeypatch):
    monkeypatch.setattr(command, "RECORD", tmp_path / "r.json")
    drive = {"turn": circle()}
    write(tmp_path, "bot", gazebo=drive, paddock={"turn": circle(rate=0.9)})
    for number, rate in ((2, 0.89), (3, 0.85)):
        (tmp_path / f"bot.gazebo.{number}.json").write_text(
            json.dumps({"paths": {"turn": circle(rate=rate)}})
        )
    command.update(tmp_path)
    [turn] = command.compare(command.recorded())["bot"]
    assert [round(run.rate, 2) for run in turn.gazebo] == [0.8, 0.89, 0.85]
    assert len(turn.paddock) == 1 and turn.verdict == command.VARIES


def motions(*pairs):
    return tuple(command.Motion(way=1.0, speed=speed, rate=rate) for speed, rate in pairs)


@pytest.mark.parametrize(
    "gazebo, paddock, verdict",
    [
        ([(0.5, 0.60)], [(0.5, 0.63)], command.ALIKE),  # within 5 %
        ([(0.5, 0.60)], [(0.5, 0.64)], command.OTHERWISE),
        ([(0.5, 0.60)], [(0.53, 0.60)], command.OTHERWISE),  # the speed alone
        ([(0.05, 0.60)], [(0.059, 0.60)], command.ALIKE),  # 0.01 m/s
        ([(0.5, 0.60), (0.5, 0.64)], [(0.5, 0.66)], command.ALIKE),  # near one of two runs
        ([(0.5, 0.60), (0.5, 0.72)], [(0.5, 0.60)], command.VARIES),
        ([(0.5, 0.60)], [(0.5, 0.66), (0.5, 0.62), (0.5, 0.61)], command.ALIKE),  # the median
        ([(0.5, 0.60)], [(0.5, 0.3), (0.5, 0.6), (0.5, 0.61)], command.OTHERWISE),  # ours vary
    ],
)
def test_a_driven_phase_is_alike(gazebo, paddock, verdict):
    assert command.Compared("turn", motions(*gazebo), motions(*paddock)).verdict == verdict


def test_a_robot_that_stands_in_gazebo_is_not_driven():
    cases = (
        *(((0.03, 0.0), "turn", True), ((0.0, -0.1), "spot", True)),
        *(((0.01, 0.01), "turn", False), ((0.5, 0.0), "rest", False)),
    )
    for pair, phase, driven in cases:
        runs = motions(pair)
        assert command.Compared(phase, runs, runs).is_driven == driven


def test_each_recorded_package_is_public_or_paddocks_own():
    assert set(command.recorded()) - set(command.packages()) == {
        name for name in command.recorded() if name.startswith("own-")
    }


def test_the_page_is_that_of_the_record():
    cases = command.recorded()
    assert command.PAGE.read_text(encoding="utf-8") == command.page(command.compare(cases))
    assert {"own-car", "own-truck", "husky-melodic-playpen"} <= set(cases) and len(cases) >= 20
    for name in ("beside_gazebo", "beside_gazebo_speeds", "all_paths", "all_yaw_rates"):
        assert (ROOT / "docs" / "images" / f"{name}.png").is_file()
