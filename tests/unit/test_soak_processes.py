"""What the bench starts: observers that answer late or end, processes with a tag."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rospy
import rosservice
from gazebo_msgs.srv import SetModelState

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import launching  # noqa: E402
from figures import BenchError  # noqa: E402
from launching import Observer, Unresponsive  # noqa: E402
from observers.soak import NUMBERS, TEXTS, answer, fill  # noqa: E402
from soaking.process_under_test import ProcessesUnderTest  # noqa: E402

LIMIT = 30.0  # [s]
# Answers with the question after its delay, or ends.
ECHO = """
import json, os, sys, time
for line in sys.stdin:
    question = json.loads(line)
    while not os.path.exists(question.get("after", "/")):
        time.sleep(0.01)
    if question["what"] == "end":
        sys.exit(3)
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


def test_what_was_told_is_answered_to_nobody(echo):
    echo.send(what="told")
    assert echo.request(limit=LIMIT, what="asked") == {"what": "asked"}


def test_an_observer_that_has_ended_says_so_each_time(echo):
    for _ in range(2):
        with pytest.raises(BenchError, match="ended early .exit status 3") as caught:
            echo.request(limit=LIMIT, what="end")
        assert not isinstance(caught.value, Unresponsive)
    echo.close()  # with a question that was never read


def test_it_waits_for_its_processes_and_ends_what_is_left(tmp_path):
    processes = ProcessesUnderTest(tmp_path / "processes", "said.log", EXTRA="1")
    (processes.temporary / "left").touch()
    (processes.temporary / "runtime-root").mkdir()
    try:
        first = processes.popen("sh", "-c", "echo $EXTRA $ROS_MASTER_URI; exec sleep 1000")
        processes.popen("python3", "-c", "import time; time.sleep(1000)", "__name:=rosout")
        end = time.monotonic() + LIMIT
        while not {"sleep", "rosout"} <= set(processes.roles()) and time.monotonic() < end:
            time.sleep(0.01)
        assert processes.output() == f"1 http://127.0.0.1:{processes.port}\n"
        found, _ = processes.wait_ended(0.1, spared=("rosout",))
        assert found.left == ["sleep 1000"] and found.seconds >= 0.1
        first.send_signal(signal.SIGTERM)
        found, files = processes.wait_ended(LIMIT, spared=("rosout",))
        assert found.left == [] and files == ["left"]
        found, _ = processes.wait_ended(1.0, begin=time.monotonic() - 100 * LIMIT)
        assert found.left  # it looks once at least
    finally:
        processes.close()
    assert processes.roles() == {}


@pytest.mark.parametrize(
    "error",
    [
        rospy.ServiceException("refused"),
        rosservice.ROSServiceException("refused"),
        ConnectionResetError("refused"),
    ],
)
def test_a_refused_call_is_an_answer(error):
    class Hands:
        def step(self, count):
            raise error

    assert answer(Hands(), what="step", count=3) == {"error": "step: refused"}


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


def test_fuzzed_values_fill_a_message_in_depth():
    request = SetModelState._request_class()
    fill(request, random.Random(3))
    state = request.model_state
    assert state.model_name in TEXTS
    values = [getattr(state.pose.orientation, name) for name in "xyzw"]
    assert set(map(repr, values)) <= set(map(repr, NUMBERS)) and any(values)
