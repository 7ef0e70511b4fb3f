"""The pose plot: stored poses, CSV, plot, valid and invalid bags."""

import csv
import math
import sys

import pytest
import rosbag
import rospy
from cybertruck.plot import command
from cybertruck.plot.trajectory import Trajectory, plot, select_spaced
from geometry_msgs.msg import PoseStamped
from matplotlib import image
from nav_msgs.msg import Odometry
from std_msgs.msg import String


def quarter(count=200, radius=2.0):
    """Poses on a quarter circle to the left."""
    for index in range(count + 1):
        angle = 0.5 * math.pi * index / count
        yield (0.1 * index, radius * math.sin(angle), radius * (1.0 - math.cos(angle)), angle)


def filled(**settings):
    trajectory = Trajectory(**settings)
    for row in quarter():
        trajectory.add(*row)
    trajectory.add_goal(1.0, 2.0, 2.0)
    trajectory.finish()
    return trajectory


def write_bag(path, topic="/odom"):
    with rosbag.Bag(str(path), "w") as bag:
        for time, x, y, heading in quarter():
            message = Odometry()
            message.header.stamp = rospy.Time.from_sec(1.0 + time)
            message.pose.pose.position.x, message.pose.pose.position.y = x, y
            message.pose.pose.orientation.z = math.sin(0.5 * heading)
            message.pose.pose.orientation.w = math.cos(0.5 * heading)
            bag.write(topic, message, message.header.stamp)
        goal = PoseStamped()
        goal.header.stamp = rospy.Time(3)
        goal.pose.position.x, goal.pose.position.y = 2.0, 0.5
        bag.write("/goal/pose", goal, rospy.Time.from_sec(1.0))
        bag.write("/chatter", String("noise"), rospy.Time.from_sec(1.0))


def test_length_and_duration():
    trajectory = filled()
    assert trajectory.length == pytest.approx(math.pi, rel=1e-4)
    assert trajectory.duration == pytest.approx(20.0)


def test_spacing_thins_out_but_keeps_the_ends():
    trajectory = filled(spacing=0.5)
    assert len(trajectory.rows) < 120  # one a degree
    assert trajectory.rows[0][1:3] == (0.0, 0.0)
    assert trajectory.rows[-1][1:3] == pytest.approx((2.0, 2.0))


@pytest.mark.parametrize(
    "row",
    [
        (math.nan, 0.0, 0.0, 0.0),
        (5.0, math.inf, 0.0, 0.0),
        (5.0, 0.0, 0.0, math.nan),
        (0.5, 3.0, 3.0, 0.0),
    ],
)
def test_poses_that_are_left_out(row):
    trajectory = Trajectory()
    assert trajectory.add(1.0, 0.0, 0.0, 0.0)
    assert not trajectory.add(*row)
    assert len(trajectory.rows) == 1


def test_a_latched_goal_counts_once():
    trajectory = filled()
    trajectory.add_goal(1.0, 2.0, 2.0)
    trajectory.add_goal(9.0, 2.0, 2.0)
    trajectory.add_goal(9.0, math.nan, 2.0)
    assert trajectory.goals == [(1.0, 2.0, 2.0), (9.0, 2.0, 2.0)]


def test_a_goal_of_a_bag_has_its_time_and_place(tmp_path):
    write_bag(tmp_path / "a.bag")
    trajectory = command.from_bag(str(tmp_path / "a.bag"), "/odom", "/goal/pose")
    assert trajectory.goals == [(3.0, 2.0, 0.5)]


def test_csv(tmp_path):
    filled().write_csv(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open() as stream:
        rows = list(csv.reader(stream))
    assert rows[0] == ["time", "x", "y", "heading"]
    assert len(rows) == 202
    assert [float(value) for value in rows[-1]] == pytest.approx(
        [20.0, 2.0, 2.0, 0.5 * math.pi], abs=1e-4
    )


def test_arrows_are_evenly_spaced():
    rows = select_spaced(filled().rows, 0.5)
    assert len(rows) == 1 + int(math.pi / 0.5)


def test_plot_shows_path_and_goal(tmp_path):
    plot(filled(), tmp_path / "a.png", "title")
    pixels = image.imread(str(tmp_path / "a.png"))[:, :, :3]
    assert pixels.shape[:2] == (770, 770)

    def count(color):
        return int((abs(pixels - [value / 255.0 for value in color]).max(axis=2) < 0.02).sum())

    assert count((0x1F, 0x5F, 0xA8)) > 500  # the path
    assert count((0xC0, 0x39, 0x2B)) > 50  # the goal
    assert count((0x2E, 0x8B, 0x3D)) > 30  # the start


def test_plot_of_one_pose(tmp_path):
    trajectory = Trajectory()
    trajectory.add(0.0, 1.0, 1.0, 0.0)
    trajectory.finish()
    plot(trajectory, tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 0


def test_nothing_recorded():
    with pytest.raises(ValueError, match="no pose"):
        Trajectory().finish()


def test_from_a_bag(tmp_path, monkeypatch, capsys):
    write_bag(tmp_path / "run.bag")
    monkeypatch.setattr(
        sys,
        "argv",
        [
            "plot_pose",
            "--bag",
            str(tmp_path / "run.bag"),
            "--output",
            str(tmp_path / "new" / "run.png"),
        ],
    )
    assert command.main() == 0
    assert (tmp_path / "new" / "run.png").is_file() and (tmp_path / "new" / "run.csv").is_file()
    assert "3.14 m in 20.0 s, 1 goals" in capsys.readouterr().out


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda path: write_bag(path, "/ground_truth/odom"), "topics with odometry: /ground_truth"),
        (lambda path: path.write_text("no bag"), "run.bag"),
        (lambda path: None, "run.bag"),
    ],
)
def test_bad_bags(tmp_path, monkeypatch, capsys, make, words):
    make(tmp_path / "run.bag")
    monkeypatch.setattr(
        sys,
        "argv",
        ["plot_pose", "--bag", str(tmp_path / "run.bag"), "--output", str(tmp_path / "run.png")],
    )
    assert command.main() == 1
    assert words in capsys.readouterr().err
    assert not (tmp_path / "run.png").exists()


@pytest.mark.parametrize("text", ["-1", "nan", "inf", "long"])
def test_bad_durations(monkeypatch, text):
    monkeypatch.setattr(sys, "argv", ["plot_pose", f"--duration={text}"])
    with pytest.raises(SystemExit):
        command.main()
