"""What the bench starts: observers that answer late, nodes that end while they import."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))


LIMIT = 30.0  # [s]


NODES = (
    "src/bullet_bridge/nodes/bridge",
    "src/track_model/nodes/odom_tf",
    "src/standins/gazebo_ros/scripts/spawn_model",
    "src/standins/controller_manager/scripts/spawner",
)
# What rospy's imports do with a KeyboardInterrupt, told by a module that each node imports.
SWALLOWING = """
import os, time
print("here", flush=True)
while True:
    try:
        time.sleep(1e4)
    except:
        print("swallowed", flush=True)
"""


@pytest.mark.parametrize("script", NODES)
def test_a_node_of_the_world_ends_while_it_imports(tmp_path, script):
    (tmp_path / "rospy.py").write_text(SWALLOWING)
    root = Path(__file__).resolve().parents[2]
    paths = [str(tmp_path), os.environ.get("PYTHONPATH", "")]
    with subprocess.Popen(
        [sys.executable, str(root / script)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        try:
            assert process.stdout.readline() == "here\n"
            process.send_signal(signal.SIGINT)
            assert process.stdout.readline() == "" and process.wait(LIMIT) == -signal.SIGINT
        finally:
            process.kill()
