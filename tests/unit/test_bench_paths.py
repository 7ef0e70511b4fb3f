"""bench/paths_beside_gazebo.py: figures of paths, the record, the page, bad input."""

import json
import math
import sys
from pathlib import Path

import cv2

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
    (tmp_path / "docs" / "images").mkdir(parents=True)
    drives = {"turn": circle(), "stop": circle(speed=0.1)}
    write(tmp_path, "bot", gazebo=drives, paddock=dict(drives, turn=circle(speed=0.6)))
    write(tmp_path, "car", gazebo=drives, paddock=drives)
    assert command.main(["--update", str(tmp_path)]) == 0
    text = (tmp_path / "docs" / "beside-gazebo.md").read_text()
    assert "1 of 2 are. The others" in text.replace("\n", " ")
    assert "| bot | turn | 0.499, 0.800 | 0.599, 0.800 | no |" in text
    assert "| car | turn | 0.499, 0.800 | 0.499, 0.800 | yes |" in text
    for kind in ("paths", "speeds", "yaw_rates"):
        image = cv2.imread(str(tmp_path / "docs" / "images" / f"beside_gazebo_{kind}.png"))
        blue = (abs(image.astype(int) - (143, 111, 47)).max(axis=2) < 40).sum()
        orange = (abs(image.astype(int) - (30, 84, 179)).max(axis=2) < 40).sum()
        assert blue > 100 and orange > 100
    # a package that a folder does not have stays
    (tmp_path / "more").mkdir()
    write(tmp_path / "more", "bot", gazebo=drives, paddock=drives)
    assert command.main(["--update", str(tmp_path / "more")]) == 0
    assert set(command.recorded()) == {"bot", "car"}


def test_the_page_is_that_of_the_record():
    cases = command.recorded()
    assert command.PAGE.read_text(encoding="utf-8") == command.page(command.compare(cases))
    assert {"own-car", "own-truck", "husky-melodic-playpen"} <= set(cases) and len(cases) >= 20
    for kind in ("paths", "speeds", "yaw_rates"):
        assert (ROOT / "docs" / "images" / f"beside_gazebo_{kind}.png").is_file()
