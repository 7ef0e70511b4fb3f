"""What the bench starts: observers that answer late, nodes that end while they import."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import launching  # noqa: E402
from launching import Observer, Unresponsive  # noqa: E402

LIMIT = 30.0  # [s]
# Answers with the question after its delay.
ECHO = """
import json, os, sys, time
for line in sys.stdin:
    question = json.loads(line)
    while not os.path.exists(question.get("after", "/")):
        time.sleep(0.01)
    print(json.dumps(question), flush=True)
"""


@pytest.fixture(name="echo")
def _echo(tmp_path, monkeypatch):
    script = tmp_path / "echo.py"
    script.write_text(ECHO)
    monkeypatch.setattr(launching, "SCRIPT", script)
    made = Observer(dict(os.environ), None, "echo")
    yield made
    made.close()


def test_a_late_answer_is_not_taken_for_the_next(echo, tmp_path):
    gate = tmp_path / "gate"
    with pytest.raises(Unresponsive, match="slow.*not answered within 0.1 s"):
        echo.request(limit=0.1, what="slow", after=str(gate))
    gate.touch()
    assert echo.request(limit=LIMIT, what="next") == {"what": "next"}


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
