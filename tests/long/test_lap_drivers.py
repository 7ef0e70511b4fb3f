"""Whole laps through ./run lap's launch file: by pursuit, slider, buttons and a policy."""

import os

import numpy as np
from laps import LOOP, SMALL_LENGTH, LapCase, lap, open_route
from networks import lane_keeper
from paced import paced


class LapDrivers(LapCase):
    """Each test is one launch."""

    def test_pursuit_on_an_open_route(self):
        track = os.path.join(self.folder, "route.npy")
        np.save(track, open_route())
        result = lap(self.folder, paced(*LOOP), driver="pursuit", track=track, camera_rate=5)
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual((start["outcome"], start["penalty"]), ("lap", 0.0))
        self.assertLess(start["mean_lateral_error"], 0.03)
        self.check_files(result["film_frames"])

    def test_slider(self):
        result = lap(
            self.folder,
            paced(*LOOP, lag=0.2, nodes=("/slider_driver", "/control")),
            driver="slider",
            track=self.small_track(),
            camera_rate=5,
        )
        self.assertEqual(result["error"], "")
        self.assertTrue(result["ok"])
        [start] = result["starts"]
        self.assertEqual((start["outcome"], start["penalty"]), ("lap", 0.0))
        self.assertAlmostEqual(start["lap_time"], SMALL_LENGTH / 0.3, delta=3.0)  # at 0.3 m/s
        self.assertLess(start["mean_lateral_error"], 0.08)
        self.assertGreater(result["film_frames"], 50)
        self.check_files(result["film_frames"])

    def test_policy(self):
        """The lap takes the time that it takes in the gym."""
        track = self.small_track()
        policy = lane_keeper(os.path.join(self.folder, "policy.onnx"), speed=-0.8)
        result = lap(
            self.folder,
            paced(*LOOP, lag=0.08),  # it acts each 0.067 s
            driver="policy",
            policy=policy,
            track=track,
            camera_rate=5,
        )
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual((start["outcome"], start["penalty"]), ("lap", 0.0))
        expected = gym_lap_time(policy, track)
        print(f"a lap takes {start['lap_time']:.3f} s, in the gym {expected:.3f} s")
        self.assertAlmostEqual(start["lap_time"], expected, delta=0.02 * expected)
        self.check_files(result["film_frames"])

    def test_buttons(self):
        result = lap(self.folder, (), driver="buttons", track="easy", roam=8.0, real_time_factor=2)
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual(start["outcome"], "roamed")
        self.assertGreater(start["driven"], 0.5)
        self.check_files(result["film_frames"])


def gym_lap_time(policy, track):
    """Time [s] that it takes in the gym, by the same referee from the same start."""
    from paddock_gym.envs.deepracer import DeepRacerEnv
    from paddock_gym.evaluation.laps import PolicyDriver, line_to_line

    env = DeepRacerEnv(track, randomize=())
    found = line_to_line(env, PolicyDriver(policy))
    env.close()
    return found
