"""Files that cannot be read: the launch ends by itself and names the file."""

import os
import subprocess
import tempfile
import unittest

from paddock_common.process import free_port

DEADLINE = 120.0  # wall time for a launch to refuse its input [s]


class RefuseStart(unittest.TestCase):
    """Launches on masters of their own."""

    def launch(self, *arguments):
        """Runs roslaunch to its own end and returns what it printed."""
        port = free_port()
        done = subprocess.run(
            ["roslaunch", "-p", str(port), *arguments],
            text=True,
            check=False,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}"),
            timeout=DEADLINE,
        )
        return done.stdout

    def test_a_track_of_two_points(self):
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as stream:
            stream.write("points: [[0, 0], [1, 0]]\nwidth: 0.76\n")
            stream.flush()
            output = self.launch(
                "track_model", "world.launch", "headless:=true", "track:=" + stream.name
            )
        self.assertIn(stream.name, output)
