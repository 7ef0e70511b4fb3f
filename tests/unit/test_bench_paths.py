"""bench/paths_beside_gazebo.py: figures of paths, the record, the page, bad input."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))

import paths_beside_gazebo as command  # noqa: E402


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
