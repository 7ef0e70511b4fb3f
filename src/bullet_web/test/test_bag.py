"""Replays of rosbags."""

import numpy as np
import pytest
import rosbag
import rospy
from nav_msgs.msg import Odometry
from replay_rig import ARM, data_of, numbers
from sensor_msgs.msg import JointState

from bullet_web import bag

WORLD = '<sdf version="1.6"><world name="w"></world></sdf>'


@pytest.fixture
def folder(tmp_path, monkeypatch, page_files):
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "empty.world").write_text(WORLD)
    monkeypatch.setattr(bag.files, "read", lambda names: page_files)
    monkeypatch.setattr(bag, "output_of", lambda program, *rest: (tmp_path / rest[0]).read_text())
    return tmp_path


def written(folder, messages):
    """A bag of (topic, message, time)."""
    path = folder / "drive.bag"
    with rosbag.Bag(str(path), "w") as target:
        for topic, message, time in messages:
            target.write(topic, message, rospy.Time.from_sec(time))
    return path


def odometry(time, x, frame="base"):
    message = Odometry(child_frame_id=frame)
    message.header.stamp = rospy.Time.from_sec(time)
    message.pose.pose.position.x = x
    message.pose.pose.orientation.w = 1.0
    return message


def options(folder, **given):
    words = ["drive.bag", "--urdf", "arm.urdf", "--world", str(folder / "empty.world")]
    options = bag.command_line().parse_args(words)
    options.bag, options.out = str(folder / "drive.bag"), str(folder / "drive.html")
    vars(options).update(given)
    return options


def test_a_bag_becomes_frames_with_poses_and_joints(folder):
    messages = [("/joint_states", JointState(name=["axle", "other"], position=[0.5, 9.0]), 0.5)]
    messages += [("/odom", odometry(1.0 + 0.1 * i, 0.2 * i), 1.0 + 0.1 * i) for i in range(11)]
    messages += [("/joint_states", JointState(name=["axle"], position=[1.5]), 1.65)]
    written(folder, messages)
    assert ": 11 frames, 1.0 s, " in bag.make(options(folder))
    data = data_of((folder / "drive.html").read_text())
    (part,) = data["parts"]
    rows = numbers(part["rows"], "<f4").reshape(11, -1)
    assert rows[:, 0] == pytest.approx(0.2 * np.arange(11), abs=1e-6)
    assert rows[:6, 7] == pytest.approx(0.5) and rows[7:, 7] == pytest.approx(1.5)
    assert numbers(part["times"], "<f8") == pytest.approx(1.0 + 0.1 * np.arange(11))


def test_the_pose_of_a_link_is_that_of_the_robot_s_root(folder):
    written(folder, [("/odom", odometry(t, 0.0, "arm/plate"), t) for t in (1.0, 2.0)])
    bag.make(options(folder))
    (part,) = data_of((folder / "drive.html").read_text())["parts"]
    assert numbers(part["rows"], "<f4").reshape(2, -1)[:, 2] == pytest.approx(-0.3)


def test_stamps_of_two_clocks_are_shown_by_the_times_of_the_bag(folder):
    """Each message began a part with a scene of its own: too large, and beyond 400 s."""
    messages = [("/odom", odometry(1e3 * (i % 2) + 0.1 * i, i), 1 + 0.1 * i) for i in range(2000)]
    written(folder, messages)
    said = bag.make(options(folder))
    assert ": 2000 frames, 199.9 s, " in said and "the stamps of /odom go back more than" in said
    assert len(data_of((folder / "drive.html").read_text())["parts"]) == 1


def test_poses_that_are_no_numbers_are_left_out(folder):
    bad = odometry(1.5, np.nan)
    written(folder, [("/odom", odometry(1.0, 0.0), 1.0), ("/odom", bad, 1.5)])
    assert ": 1 frames" in bag.make(options(folder))


@pytest.mark.parametrize(
    "messages, given, reason",
    [
        ([("/a", JointState(), 1.0)], {}, "the bag has no topic of type nav_msgs/Odometry"),
        (
            [("/odom", odometry(1.0, 0.0), 1.0)],
            {"urdf": ""},
            "nothing in the bag tells which robot",
        ),
        ([("/odom", odometry(1.0, 0.0), 1.0)], {"odometry": "/x"}, "--odometry is '/x'; the bag's"),
        ([("/odom", odometry(1.0, np.inf), 1.0)], {}, "/odom has no message with a valid pose"),
    ],
)
def test_bags_that_cannot_be_shown(folder, messages, given, reason):
    written(folder, messages)
    with pytest.raises(bag.BagError, match=reason):
        bag.make(options(folder, **given))
    assert not (folder / "drive.html").exists()


def test_a_file_that_is_no_bag_is_one_line(folder, capsys):
    path = folder / "drive.bag"
    path.write_text("no bag")
    assert bag.main([str(path), "--urdf", "arm.urdf"]) == 1
    assert capsys.readouterr().err.startswith(f"replay: {path} is no bag that can be read")


def test_programs_that_fail_are_named(monkeypatch):
    with pytest.raises(bag.BagError, match="no-such-program: No such file"):
        bag.output_of("no-such-program")
    with pytest.raises(bag.BagError, match="false: exit code 1"):
        bag.output_of("false")


def test_addresses_are_resolved(monkeypatch):
    assert bag.resolve("/a/b") == "/a/b"
    assert bag.resolve("file:///a/b") == "/a/b"
    assert bag.resolve("package://no_such_package/b") == "package://no_such_package/b"
