"""A lap on an imported open route, as ./run lap drives it; tests/long/ has the other drivers."""

import os

import numpy as np
from laps import LOOP, LapCase, lap, open_route
from paced import paced


class LapRun(LapCase):
    """One launch."""

    def test_pursuit_on_an_open_route(self):
        track = os.path.join(self.folder, "route.npy")
        np.save(track, open_route())
        result = lap(self.folder, paced(*LOOP), driver="pursuit", track=track, camera_rate=5)
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual((start["outcome"], start["penalty"]), ("lap", 0.0))
        self.assertLess(start["mean_lateral_error"], 0.03)
        self.check_files(result["film_frames"])
