"""The package's example that learns goals by lidar."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from paddock_gym.policy.onnx_policy import OnnxPolicy

EXAMPLES = Path(__file__).resolve().parents[2] / "src" / "paddock_gym" / "examples"
pytestmark = pytest.mark.timeout(3600)


def test_a_robot_learns_to_reach_goals_by_its_lidar(tmp_path):
    path = tmp_path / "goals.onnx"
    main = runpy.run_path(str(EXAMPLES / "reach_goals.py"))["main"]
    words = "--seconds 3600 --starts 30".split()
    ends = main([str(path), *words])
    assert sum(ends.values()) == 30
    assert ends["reached"] >= 24, ends
    policy = OnnxPolicy(str(path), "robot")
    seen = {"scan": np.ones(24, np.float32), "goal": np.array((1.0, 0.0, 1.0), np.float32)}
    [(topic, kind, values)] = policy.command(seen)
    assert (topic, kind, len(values)) == ("/cmd_vel", "geometry_msgs/Twist", 2)
