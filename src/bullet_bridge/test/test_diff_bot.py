"""A differential drive on the ground, without a ROS master: limits, a circle, its time-out."""

import math
from pathlib import Path

import bot_rig
import pytest
import yaml
from bullet_sim.formats.sdf.world import ground_plane
from bullet_sim.pose import Pose
from bullet_sim.world import World
from geometry_msgs.msg import Twist
from paddock_common.geometry import yaw_of

FOLDER = Path(__file__).resolve().parents[3] / "tests" / "ros"
SPEED, RATE = 0.4, 0.8  # [m/s], [rad/s]: a circle with a radius of 0.5 m
ACCELERATION, MAX_SPEED, TIMEOUT = 2.0, 1.0, 0.25  # [m/s^2], [m/s], [s] in diff_drive.yaml
EVERY = 20  # steps from one command to the next: one message of odometry


class Base(bot_rig.Bot):
    """diff_bot with its controller running."""

    def __init__(self, monkeypatch):
        world = World()
        world.spawn(ground_plane())
        params = yaml.safe_load((FOLDER / "diff_drive.yaml").read_text())
        super().__init__(
            monkeypatch,
            (FOLDER / "diff_bot.urdf").read_text(),
            {f"/bot/{name}": value for name, value in params.items()},
            Pose(),
            world,
        )
        self.start("mobile_base")
        self.odom = self.endpoints["/bot/mobile_base/odom"].messages

    def drive(self, seconds, speed=None, rate=0.0):
        """Drives for a time by a command at 50 Hz; without a speed there is none.

        Returns:
            The odometry and the true pose at its times.
        """
        pairs = []
        for _ in range(round(seconds / (EVERY * self.world.time_step))):
            if speed is not None:
                message = Twist()
                message.linear.x, message.angular.z = speed, rate
                self.endpoints["/bot/mobile_base/cmd_vel"].call(message)
            self.run(EVERY)
            assert self.odom[-1].header.stamp.to_sec() == pytest.approx(self.world.time)
            pairs.append((self.odom[-1], self.model.pose))
        return pairs


@pytest.fixture(name="base")
def _base(monkeypatch):
    made = Base(monkeypatch)
    yield made
    made.world.close()


def turned(before, after):
    """Angle from one heading to another, the shorter way [rad]."""
    return (after - before + math.pi) % (2.0 * math.pi) - math.pi


def relative(start, end):
    """A pose (x, y, yaw) in the frame of another."""
    dx, dy, yaw = end[0] - start[0], end[1] - start[1], start[2]
    return (
        math.cos(yaw) * dx + math.sin(yaw) * dy,
        -math.sin(yaw) * dx + math.cos(yaw) * dy,
        turned(yaw, end[2]),
    )


def believed(message):
    """(x, y, yaw) of an odometry."""
    pose = message.pose.pose
    return pose.position.x, pose.position.y, yaw_of(pose.orientation)


def true(pose):
    """(x, y, yaw) of a Pose."""
    return (*pose.position[:2], pose.rpy[2])


def test_a_circle_has_its_radius_and_odometry_agrees_with_the_truth(base):
    base.drive(1.0, SPEED, RATE)
    pairs = base.drive(2.0 * math.pi / RATE + 0.25, SPEED, RATE)
    (first, start), (last, end) = pairs[0], pairs[-1]
    headings = [true(pose)[2] for _, pose in pairs]
    travelled = sum(map(turned, headings, headings[1:]))
    seconds = (last.header.stamp - first.header.stamp).to_sec()
    assert travelled > 2.0 * math.pi
    assert travelled / seconds == pytest.approx(RATE, rel=0.02)
    assert last.twist.twist.linear.x == pytest.approx(SPEED, rel=0.01)
    assert last.twist.twist.angular.z == pytest.approx(RATE, rel=0.01)
    # both paths, brought to a common start, stay together
    odometry, truth = relative(believed(first), believed(last)), relative(true(start), true(end))
    assert math.dist(odometry[:2], truth[:2]) < 0.03
    assert turned(odometry[2], truth[2]) == pytest.approx(0.0, abs=0.06)


def test_covariances_and_frames_are_those_of_the_file(base):
    base.drive(0.2, 0.3, 0.1)
    message = base.odom[-1]
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_footprint")
    assert message.pose.covariance[0] == 0.001 and message.twist.covariance[35] == 0.03
    transform = base.endpoints["/tf"].messages[-1].transforms[0]
    assert (transform.header, transform.child_frame_id) == (message.header, "base_footprint")
    assert transform.transform.translation.x == message.pose.pose.position.x
    assert transform.transform.rotation == message.pose.pose.orientation
