"""./run lap's launch file on a master of its own; the other drivers are tests/long/."""

from laps import LOOP, SMALL_LENGTH, LapCase, lap
from paced import paced


class RunLap(LapCase):
    """A lap by the camera, from the launch to its files."""

    def test_line(self):
        result = lap(self.folder, paced(*LOOP, lag=0.1), driver="line", track=self.small_track())
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual((start["outcome"], start["penalty"]), ("lap", 0.0))
        self.assertLess(start["mean_lateral_error"], 0.05)
        # 0.6 m/s on straights, slower in bends; corners are cut a little
        self.assertGreater(start["lap_time"], 0.95 * SMALL_LENGTH / 0.62)
        self.assertLess(start["lap_time"], 1.05 * SMALL_LENGTH / 0.4)
        self.check_files(result["film_frames"])
