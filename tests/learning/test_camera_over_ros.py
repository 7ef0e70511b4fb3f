"""A policy that steers the DeepRacer by its camera alone: as good over ROS as in the gym.

    ./run exec python tests/learning/test_camera_over_ros.py 100      # starts

It learns by imitation, in a minute: pure pursuit, which knows the lane, drives and says what it
would do with each image; a linear function of the image learns that, drives itself, and learns from
what it then sees (DAgger: Ross et al., AISTATS 2011). `./run drive-by` commands the car of
world.launch by it, from the same starts.
"""

import contextlib
import math
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import onnx
import pytest
from deepracer_control.drivers.pursuit import arc_curvature
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import GetModelState, SetModelState
from onnx import TensorProto, helper, numpy_helper
from paddock_gym.envs.describe import policy_description
from paddock_gym.envs.robot import RobotEnv
from paddock_gym.envs.tasks import Lane
from paddock_gym.policy.description import KEY, OUTPUT
from paddock_gym.policy.onnx_policy import OnnxPolicy
from track_model.track import load_track

ROOT = Path(__file__).resolve().parents[2]
RATE = 10  # images and actions a simulated second [Hz]
LAUNCH = (
    "track_model world.launch headless:=true lockstep:=true lidar:=false state_publisher:=false "
    f"camera_width:=64 camera_height:=48 camera_rate:={RATE}"
)
CAMERA, CAR = "/camera/image", "racecar"
WHEELS = [f"{side}_{end}_wheel_velocity" for end in ("rear", "front") for side in ("left", "right")]
HINGES = [f"{side}_steering_hinge_position" for side in ("left", "right")]
COMMANDS = [f"/{CAR}/{name}_controller/command" for name in WHEELS + HINGES]
SPEED, RADIUS, WHEELBASE, MOST = 0.8, 0.03, 0.164, 0.5  # [m/s], [m], [m], of steering [rad]
AHEAD = 0.5  # pure pursuit's goal on the lane [m]
WAY, LONGEST = 4.0, 80  # that a run has to come along the lane [m], its actions at most
ROUNDS, RUNS = 3, 12  # of learning
LIMIT = 300.0  # wall time until ROS is up, and of one step [s]
pytestmark = pytest.mark.timeout(3600)


class Track(Lane):
    """The lane, which no policy observes; a run is good after WAY metres."""

    spaces = {}

    def __init__(self):
        track = load_track("default")
        self.points = np.asarray(track.centreline)[:-1]
        super().__init__(self.points, closed=True, width=float(track.spec.width))

    def observe(self, state):
        return {}

    def steering(self, x, y, yaw):
        """Of pure pursuit [rad]."""
        s, _ = self.nearest(x, y)
        u, v, _ = self.place(s + AHEAD)
        c, n = math.cos(yaw), math.sin(yaw)
        at = (u - x) * c + (v - y) * n, (v - y) * c - (u - x) * n
        return float(np.clip(math.atan(WHEELBASE * arc_curvature(*at)), -MOST, MOST))

    def starts(self, count, seed):
        """(x, y [m], yaw [rad]) of runs."""
        rng = np.random.default_rng(seed)
        for _ in range(count):
            x, y, yaw = self.place(rng.uniform(0.0, self.length))
            side = rng.uniform(-0.15, 0.15) * self.width
            yaw += rng.uniform(-0.3, 0.3)
            yield float(x - side * math.sin(yaw)), float(y + side * math.cos(yaw)), float(yaw)


class Course:
    """Judges a run by where the car is."""

    def __init__(self, track, x, y):
        self._track, self._s, self._way = track, track.nearest(x, y)[0], 0.0

    def end(self, x, y):
        """ "good", "off" or "" after an action."""
        s, offset = self._track.nearest(x, y)
        self._way += math.remainder(s - self._s, self._track.length)
        self._s = s
        if abs(offset) > self._track.width / 2.0:
            return "off"
        return "good" if self._way >= WAY else ""


def environment(track):
    """The car of the launch file, observed by its camera."""
    wheel, hinge = SPEED / RADIUS, MOST
    limits = {name: (-wheel, wheel) for name in COMMANDS[:4]}
    limits.update({name: (-hinge, hinge) for name in COMMANDS[4:]})
    return RobotEnv(
        LAUNCH, action=COMMANDS, limits=limits, scaled=True, observation=(CAMERA,), task=track,
        control_rate=RATE, vary=(), robot=CAR,
    )  # fmt: skip


def action(steering):
    """The environment's action for a steering [rad]."""
    return np.array([0.95] * 4 + [steering / MOST] * 2, np.float32)


def features(image):
    """Means of squares of 4x4 pixels, gray, from 0 to 1: (192,)."""
    rows, columns = image.shape[0] // 4, image.shape[1] // 4
    return image.reshape(rows, 4, columns, 4, -1).mean(axis=(1, 3, 4)).ravel() / 255.0


def drive(env, track, start, steering):
    """A run by steering(image, state) [rad]: how it ends, its images, what pursuit would do."""
    seen, _ = env.reset(seed=0, options={"start": start})
    course, images, wanted = Course(track, *start[:2]), [], []
    for _ in range(LONGEST):
        robot = env.state.robot
        image = seen[CAMERA]
        images.append(features(image))
        wanted.append(track.steering(robot.x, robot.y, robot.yaw))
        seen, *_ = env.step(action(steering(image, wanted[-1])))
        end = course.end(env.state.robot.x, env.state.robot.y)
        if end:
            break
    return end, images, wanted


def learn(env, track):
    """(192,) weights and the bias of the steering [rad] by the features."""
    images, wanted, weights = [], [], None
    for number in range(ROUNDS):
        for start in track.starts(RUNS, 1000 + number):

            def steering(image, pursuit, weights=weights):
                return pursuit if weights is None else steered(image, weights)

            _, seen, right = drive(env, track, start, steering)
            images += seen
            wanted += right
        rows = np.c_[images, np.ones(len(images))]
        ridge = np.eye(rows.shape[1]) * 1.0
        weights = np.linalg.solve(rows.T @ rows + ridge, rows.T @ np.array(wanted))
    return weights


def steered(image, weights):
    """Steering [rad] of the learned function."""
    return float(np.clip(features(image) @ weights[:-1] + weights[-1], -MOST, MOST))


def export(env, weights, path):
    """Write the policy: the image's linear function, as steered()."""
    shape = env.observation_space[CAMERA].shape
    squares = weights[:-1].reshape(shape[0] // 4, shape[1] // 4) / (16.0 * shape[2] * 255.0)
    row = np.repeat(np.repeat(squares, 4, axis=0), 4, axis=1)[..., None].repeat(shape[2], axis=2)
    matrix, bias = np.zeros((row.size, 6)), np.full(6, 0.95)
    matrix[:, 4:], bias[4:] = row.reshape(-1, 1) / MOST, weights[-1] / MOST
    nodes = [
        helper.make_node("Cast", [CAMERA], ["numbers"], to=TensorProto.FLOAT),
        helper.make_node("Flatten", ["numbers"], ["flat"]),
        helper.make_node("Gemm", ["flat", "matrix", "bias"], [OUTPUT]),
    ]
    graph = helper.make_graph(
        nodes,
        "steering",
        [helper.make_tensor_value_info(CAMERA, TensorProto.UINT8, ["n", *shape])],
        [helper.make_tensor_value_info(OUTPUT, TensorProto.FLOAT, ["n", 6])],
        [numpy_helper.from_array(value.astype(np.float32), name)
         for name, value in (("matrix", matrix), ("bias", bias))],
    )  # fmt: skip
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 15)], ir_version=8)
    helper.set_model_props(model, {KEY: policy_description(env).text()})
    onnx.save(model, path)


def in_the_gym(env, track, path, starts):
    """How runs of the policy end."""
    policy = OnnxPolicy(path, "robot")

    def steering(image, _):
        return float(policy.act({CAMERA: image})[-1]) * MOST

    return [drive(env, track, start, steering)[0] for start in starts]


@contextlib.contextmanager
def driven_by(path):
    """./run drive-by with a policy, on a master of its own; its log is printed if it fails."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        master = f"http://127.0.0.1:{probe.getsockname()[1]}"
    os.environ.update(ROS_MASTER_URI=master, ROS_IP="127.0.0.1")
    words = [str(ROOT / "run"), "drive-by", path, *LAUNCH.split()]
    with tempfile.TemporaryFile("w+") as log:
        process = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True
        )
        try:
            yield process
        except BaseException:
            log.seek(0)
            print(log.read()[-5000:], file=sys.stderr)
            raise
        finally:
            os.killpg(process.pid, signal.SIGINT)
            try:
                process.wait(90.0)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)


def over_ros(track, path, starts):
    """How runs end that the node of ./run drive-by commands."""
    import rosgraph
    import rospy
    from std_msgs.msg import Float64

    from bullet_bridge.srv import Step

    with driven_by(path) as process:
        end = time.monotonic() + LIMIT
        while not rosgraph.is_master_online():
            assert process.poll() is None and time.monotonic() < end, "no master"
            time.sleep(0.2)
        rospy.init_node("camera_over_ros", anonymous=True, disable_signals=True)
        got = []
        rospy.Subscriber(COMMANDS[-1], Float64, lambda message: got.append(message.data))
        proxies = [
            rospy.ServiceProxy(f"/gazebo/{name}", kind, persistent=True)
            for name, kind in (("step", Step), ("get_model_state", GetModelState),
                               ("set_model_state", SetModelState))
        ]  # fmt: skip
        step, get, put = proxies
        for name in ("step", "get_model_state", "set_model_state"):
            rospy.wait_for_service(f"/gazebo/{name}", LIMIT)
        while not get(CAR, "").success or not rospy.get_published_topics(f"/{CAR}"):
            assert time.monotonic() < end, "the car did not come"
            time.sleep(0.2)
        steps = round(1000 / RATE)
        while not got:  # until the node drives by what it sees
            assert time.monotonic() < end, "robot_driver does not command"
            assert step(steps, [], []).success
            time.sleep(0.3)
        ends = [_run(track, start, steps, got, proxies) for start in starts]
        rospy.signal_shutdown("done")
    return ends


def _run(track, start, steps, got, proxies):
    """One run from a start; each action waits for the one before it."""
    step, get, put = proxies
    x, y, yaw = start
    pose = get(CAR, "").pose
    pose.position.x, pose.position.y = x, y
    pose.orientation.x = pose.orientation.y = 0.0
    pose.orientation.z, pose.orientation.w = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    state = ModelState(model_name=CAR, pose=pose)

    def advance():
        before, limit = len(got), time.monotonic() + LIMIT
        answer = step(steps, [], [])
        assert answer.success, answer.status_message
        while len(got) == before and time.monotonic() < limit:
            time.sleep(0.001)
        assert len(got) > before, "robot_driver has stopped"

    assert put(state).success
    advance()  # by the command of the place before; then the node has seen the start
    assert put(state).success
    course, end = Course(track, x, y), ""
    for _ in range(LONGEST):
        advance()
        at = get(CAR, "").pose.position
        end = course.end(at.x, at.y)
        if end:
            break
    return end


def measure(count, folder):
    """(good runs in the gym, over ROS) of so many unseen starts."""
    track = Track()
    env = environment(track)
    path = os.path.join(folder, "camera.onnx")
    export(env, learn(env, track), path)
    starts = list(track.starts(count, 77))
    here = in_the_gym(env, track, path, starts)
    env.close()
    there = over_ros(track, path, starts)
    return here.count("good"), there.count("good")


def test_a_camera_car_drives_over_ros_as_in_the_gym(tmp_path):
    count = 12
    here, there = measure(count, str(tmp_path))
    assert here >= 0.9 * count, here
    assert abs(here - there) <= 1, (here, there)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        starts = int(sys.argv[1])
        print("good of {} starts: {} in the gym, {} over ROS".format(
            starts, *measure(starts, folder)
        ))  # fmt: skip
