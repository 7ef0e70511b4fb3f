"""Whole laps as ./run lap drives them: by the window's slider, and on an imported open route."""

import os

import numpy as np
from laps import LOOP, SMALL_LENGTH, LapCase, lap, open_route
from paced import paced


class LapRun(LapCase):
    """Each test is one launch."""

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

    def test_pursuit_on_an_open_route(self):
        track = os.path.join(self.folder, "route.npy")
        np.save(track, open_route())
        result = lap(self.folder, paced(*LOOP), driver="pursuit", track=track, camera_rate=5)
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual((start["outcome"], start["penalty"]), ("lap", 0.0))
        self.assertLess(start["mean_lateral_error"], 0.03)
        self.check_files(result["film_frames"])
