"""Marks a folder of drivers: each drives one lap in lockstep, judged by the referee.

Usage: ./run exec python docs/tutorials/class/grade.py TASK.yaml FOLDER MARKS.csv
"""

import csv
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

import rosgraph
import rospy
import yaml
from gazebo_msgs.srv import GetPhysicsProperties
from paddock_common.process import free_port, stop_session

from bullet_bridge.srv import Step
from track_model.msg import LapStatus

PERIOD = 0.02  # simulated time between two answers: odometry comes at 50 Hz [s]
ANSWER = "/racecar/left_steering_hinge_position_controller/command"  # the last that control sends
COLUMNS = ("name", "outcome", "marks", "lap_time", "penalty")
HERE = Path(__file__).resolve().parent


class Lap:
    """One driver's lap in a world that is up."""

    def __init__(self, task):
        self.task, self.driver, self.status = task, None, None
        rospy.init_node("grade", disable_signals=True)
        rospy.Subscriber("/referee/status", LapStatus, self._judge, queue_size=100)
        for name in ("/gazebo/step", "/gazebo/get_physics_properties", "/referee/restart"):
            rospy.wait_for_service(name, 120.0)
        physics = rospy.ServiceProxy("/gazebo/get_physics_properties", GetPhysicsProperties)
        self.steps = round(PERIOD / physics().time_step)
        self.step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)

    def _judge(self, status):
        if self.status is None or not self.status.laps:  # what comes after the finish counts not
            self.status = status

    def wait(self, done):
        """Waits, in wall time, until done() or the task's patience is over."""
        for _ in range(round(self.task["patience"] / 0.05)):
            if done():
                return True
            rospy.rostime.wallsleep(0.05)
        return False

    def ready(self):
        """Whether the car's controllers, the referee and the driver are connected."""
        state = rospy.get_master().getSystemState()[2]
        published, subscribed = (dict(part) for part in state[:2])
        listeners = subscribed.get("/racecar/odom", ())
        return (
            {"/cmd_vel", ANSWER} <= set(published) and ANSWER in subscribed and len(listeners) > 2
        )

    def run(self, driver):
        """Drives.

        Args:
            driver: subprocess.Popen.

        Returns:
            The outcome.
        """
        if not self.wait(self.ready):
            return "did not start"
        rospy.rostime.wallsleep(1.0)  # until what is registered is connected, too
        answers = 0
        for _ in range(round(self.task["time_limit"] / PERIOD)):
            if not self.step(self.steps, [ANSWER], [answers]).success:
                return "no answer" if driver.poll() is None else "crashed"
            answers = 1  # from now on: one for each message
            status = self.status
            if status and status.laps:
                return "lap"
            if status and (status.off_track or status.stuck):
                return "off track" if status.off_track else "stuck"
        return "time limit"


def marks(rules, limit, outcome, status):
    """Returns the marks of a lap."""
    if outcome != "lap":
        return 0.0
    share = (limit - status.last_lap_time) / (limit - rules["fast"])
    return max(
        0.0,
        rules["lap"]
        + rules["best"] * max(0.0, min(1.0, share))
        - rules["penalty"] * status.penalty,
    )


def grade(task, path):
    """Lets one driver drive in a world of its own; returns its row."""
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    options = dict(stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    launch = ["roslaunch", "-p", str(port), str(HERE / "class.launch"), f"track:={task['track']}"]
    launch.append(f"patience:={task['patience']}")
    running = [subprocess.Popen(launch, **options)]
    try:
        while not rosgraph.is_master_online():
            rospy.rostime.wallsleep(0.1)
        lap = Lap(task)
        running.append(subprocess.Popen([sys.executable, str(path)], **options))
        outcome = lap.run(running[-1])
        status = lap.status or LapStatus()
    finally:
        for process in reversed(running):
            stop_session(process, 30.0)
    points = marks(task["marks"], task["time_limit"], outcome, status)
    figures = (f"{value:.2f}" for value in (points, status.last_lap_time, status.penalty))
    return dict(zip(COLUMNS, (path.stem, outcome, *figures)))


def main():
    """Marks all; each in a process of its own, as a process is one ROS node."""
    task = yaml.safe_load(Path(sys.argv[1]).read_text())
    paths = sorted(Path(sys.argv[2]).glob("*.py"))
    with open(sys.argv[3], "w", newline="") as stream:
        table = csv.DictWriter(stream, COLUMNS)
        table.writeheader()
        for path in paths:
            with multiprocessing.Pool(1) as pool:
                row = pool.apply(grade, (task, path))
            table.writerow(row)
            print(*row.values(), flush=True)


if __name__ == "__main__":
    main()
