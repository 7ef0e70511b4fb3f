"""A world that cannot be had, and the pace of one that can: the simulator comes up."""

import contextlib
import os
import subprocess
import tempfile
import time
import unittest
import xmlrpc.client

from paddock_common.process import free_port, stop_session

DEADLINE = 60.0  # wall time for a launch to say what it has to say [s]
UP = "is up: step"


@contextlib.contextmanager
def launched(*arguments):
    """A launch on a master of its own, once its simulator is up: (its output, its master)."""
    uri = f"http://127.0.0.1:{free_port()}"
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(
            ["roslaunch", "-p", uri.rpartition(":")[2], *arguments],
            stdout=output,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            env=dict(os.environ, ROS_MASTER_URI=uri),
            start_new_session=True,
        )
        try:
            end = time.monotonic() + DEADLINE
            while UP not in said(output):
                if time.monotonic() > end or process.poll() is not None:
                    raise AssertionError(f"the simulator does not come up:\n{said(output)}")
                time.sleep(0.05)
            yield said(output), xmlrpc.client.ServerProxy(uri)
        finally:
            stop_session(process, DEADLINE)


def said(output):
    """What stands in a file that others write to."""
    output.seek(0)
    return output.read()


class WorldFiles(unittest.TestCase):
    """Each starts the stand-in's empty_world.launch."""

    def empty(self, *arguments):
        return launched("gazebo_ros", "empty_world.launch", "gui:=false", *arguments)

    def test_a_world_file_that_is_missing(self):
        with self.empty("world_name:=/no/such.world", "use_sim_time:=1") as (output, master):
            self.assertIn("[ERROR]", output)
            self.assertIn("/no/such.world", output)
            self.assertIn("the empty world takes its place", output)
            self.assertNotIn("Traceback", output)
            self.assertIs(master.getParam("/test", "/use_sim_time")[2], True)

    def test_the_pace_is_the_worlds_unless_it_is_given(self):
        world = (
            "<sdf version='1.6'><world name='w'><physics><max_step_size>0.004</max_step_size>"
            "<real_time_update_rate>125</real_time_update_rate></physics></world></sdf>"
        )
        with tempfile.NamedTemporaryFile("w", suffix=".world") as stream:
            stream.write(world)
            stream.flush()
            with self.empty(f"world_name:={stream.name}") as (output, _):
                self.assertIn("step 0.004 s, real time x 0.5", output)
                self.assertNotIn("[WARN]", output)
            with self.empty(f"world_name:={stream.name}", "real_time_factor:=2") as (output, _):
                self.assertIn("step 0.004 s, real time x 2", output)
