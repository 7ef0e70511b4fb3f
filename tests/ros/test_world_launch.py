"""world.launch as a user starts it: controllers, stamps, camera, transforms."""

import math
import unittest

import numpy as np
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, JointState
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import CONTROLLERS, HINGES, START_LIMIT, WHEELS, Recorder, wait_for_car, wait_until

WIDTH, HEIGHT = 640, 480  # [px]
FIELD_OF_VIEW = 1.13  # horizontal [rad]
CAMERA_RATE = 30.0  # [Hz]
KINDS = {
    "joint_state_controller": "joint_state_controller/JointStateController",
    "velocity": "velocity_controllers/JointVelocityController",
    "position": "position_controllers/JointPositionController",
}


def stamps_of(messages):
    """Returns the header stamps [s]."""
    return np.array([message.header.stamp.to_sec() for message in messages])


class WorldLaunch(unittest.TestCase):
    """Each test looks at one output of the running world."""

    @classmethod
    def setUpClass(cls):
        cls.states = wait_for_car()

    def test_the_seven_controllers_have_their_types(self):
        self.assertEqual(set(self.states), set(CONTROLLERS))
        for name, state in self.states.items():
            kind = next(kind for part, kind in KINDS.items() if part in name)
            self.assertEqual(state.type, kind, name)

    def test_joint_states_and_odometry_come_at_50_hz_of_simulated_time(self):
        messages = Recorder("/racecar/odom", Odometry).wait_count(60)
        np.testing.assert_allclose(np.diff(stamps_of(messages)), 0.02, atol=1e-6)
        frames = messages[-1].header.frame_id, messages[-1].child_frame_id
        self.assertEqual(frames, ("odom", "base_link"))
        messages = Recorder("/racecar/joint_states", JointState).wait_count(60)
        np.testing.assert_allclose(np.diff(stamps_of(messages)), 0.02, atol=1e-6)
        expected = {name + "_joint" for name in WHEELS + HINGES}
        self.assertEqual(set(messages[-1].name), expected)
        for part in (messages[-1].position, messages[-1].velocity, messages[-1].effort):
            self.assertEqual(len(part), len(expected))

    def test_camera_pictures_and_their_info_belong_together(self):
        infos = Recorder("/camera/camera_info", CameraInfo)
        camera = Recorder("/camera/image", Image)
        for recorder in (infos, camera):
            self.addCleanup(recorder.close)
        images = camera.wait_count(10, START_LIMIT)
        image = images[-1]
        self.assertEqual((image.width, image.height), (WIDTH, HEIGHT))
        self.assertEqual((image.encoding, image.step), ("rgb8", 3 * WIDTH))
        self.assertEqual(image.header.frame_id, "camera_optical_link")
        pixels = np.frombuffer(image.data, np.uint8).reshape(HEIGHT, WIDTH, 3)
        self.assertGreater(len(np.unique(pixels.reshape(-1, 3), axis=0)), 10, "an empty picture")
        stamps = stamps_of(images)
        periods = np.diff(stamps)
        self.assertTrue((periods > 0).all(), stamps)
        frames = periods * CAMERA_RATE  # a slow machine may drop frames, never shift them
        np.testing.assert_allclose(frames, np.round(frames), atol=0.1)
        info = wait_until(
            lambda: next(
                (info for info in infos.messages if info.header.stamp == image.header.stamp), None
            ),
            "a camera_info with the image's stamp",
        )
        focal = WIDTH / 2.0 / math.tan(FIELD_OF_VIEW / 2.0)  # square pixels [px]
        self.assertAlmostEqual(info.K[0], focal, delta=0.01)
