"""The command `plot_pose`: odometry, live or from a rosbag, to PNG and CSV."""

import argparse
import math
import sys
import threading
from pathlib import Path

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from paddock_common.geometry import planar_of

from cybertruck.plot.trajectory import Trajectory, plot
from paddock_common import bags, nodes

SPACING = 0.01  # between stored poses [m]


def add_odometry(trajectory, message):
    """Adds a nav_msgs/Odometry to a trajectory."""
    trajectory.add(message.header.stamp.to_sec(), *planar_of(message.pose.pose))


def add_goal(trajectory, message):
    """Adds a geometry_msgs/PoseStamped goal to a trajectory."""
    trajectory.add_goal(
        message.header.stamp.to_sec(), message.pose.position.x, message.pose.position.y
    )


def from_bag(path, topic, goal_topic) -> Trajectory:
    """Reads a trajectory from a rosbag.

    Raises:
        ValueError: The file is not a bag, or has no odometry on the topic.
    """
    trajectory = Trajectory(SPACING)
    handlers = {
        topic: ("nav_msgs/Odometry", add_odometry),
        goal_topic: ("geometry_msgs/PoseStamped", add_goal),
    }
    with bags.Bag(path) as bag:
        if bag.topics.get(topic) != "nav_msgs/Odometry":
            there = sorted(name for name, kind in bag.topics.items() if kind == "nav_msgs/Odometry")
            raise ValueError(
                f"{path}: no odometry on {topic}; topics with odometry: "
                f"{', '.join(there) or 'none'}"
            )
        for name, message, _ in bag.messages({name: kind for name, (kind, _) in handlers.items()}):
            handlers[name][1](trajectory, message)
    trajectory.finish()
    return trajectory


def record(topic, goal_topic, duration) -> Trajectory:
    """Records until Ctrl-C or for a duration.

    Args:
        duration: ROS time from the first pose [s]; 0: until Ctrl-C or rosnode kill.

    Raises:
        ValueError: No pose was received.
    """
    trajectory, lock, done = Trajectory(SPACING), threading.Lock(), threading.Event()
    stopped = [False]

    def handle(function, message):
        with lock:
            if stopped[0]:
                return
            function(trajectory, message)
            if duration and trajectory.duration >= duration:
                done.set()

    nodes.init_interruptible("plot_pose")
    rospy.on_shutdown(done.set)
    rospy.Subscriber(
        topic, Odometry, lambda message: handle(add_odometry, message), queue_size=None
    )
    rospy.Subscriber(goal_topic, PoseStamped, lambda message: handle(add_goal, message))
    rospy.loginfo(
        "plot_pose: recording %s%s",
        rospy.resolve_name(topic),
        f" for {duration:g} s" if duration else " until Ctrl-C",
    )
    while not done.wait(0.2):
        pass
    with lock:
        stopped[0] = True
    try:
        trajectory.finish()
    except ValueError:
        raise ValueError(f"no odometry on {rospy.resolve_name(topic)}") from None
    return trajectory


def non_negative(text):
    """Reads a time in seconds for argparse."""
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise ValueError
    return value


def main():
    """Records, writes, prints the paths of the files; returns the exit status."""
    parser = argparse.ArgumentParser(prog="plot_pose", description=__doc__)
    parser.add_argument(
        "--output",
        default="pose.png",
        type=Path,
        help="the PNG; the CSV goes next to it (default: pose.png)",
    )
    parser.add_argument("--bag", help="read this rosbag instead of recording")
    parser.add_argument("--topic", default="/odom", help="nav_msgs/Odometry (default: /odom)")
    parser.add_argument(
        "--goals", default="/goal/pose", help="geometry_msgs/PoseStamped (default: /goal/pose)"
    )
    parser.add_argument(
        "--duration",
        default=0.0,
        type=non_negative,
        help="seconds of ROS time to record; 0: until Ctrl-C",
    )
    parser.add_argument("--title", default="")
    options = parser.parse_args(rospy.myargv()[1:])
    try:
        if options.bag:
            trajectory = from_bag(options.bag, options.topic, options.goals)
        else:
            trajectory = record(options.topic, options.goals, options.duration)
        table = options.output.with_suffix(".csv")
        options.output.parent.mkdir(parents=True, exist_ok=True)
        trajectory.write_csv(table)
        plot(
            trajectory,
            options.output,
            options.title,
            (f"x in {options.topic} [m]", f"y in {options.topic} [m]"),
        )
    except (ValueError, OSError) as error:
        print(f"plot_pose: {error}", file=sys.stderr)
        return 1
    print(
        f"plot_pose: {len(trajectory.rows)} poses, {trajectory.length:.2f} m in "
        f"{trajectory.duration:.1f} s, {len(trajectory.goals)} goals: {options.output}, {table}"
    )
    return 0
