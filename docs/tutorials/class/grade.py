"""Marks a folder of drivers: each drives one lap in lockstep, judged by the referee.

    ./run exec python docs/tutorials/class/grade.py [--trust] TASK.yaml FOLDER MARKS.csv

What each driver prints goes to MARKS.NAME.txt, its traceback, too. bubblewrap gives each world a
network of its own, which has no other machine, and shows the driver the system's files, Paddock
and itself alone. Where the kernel allows no such processes nothing is run, unless by --trust: then
drivers have the rights of whoever marks them.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import time
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
COLUMNS = ("name", "outcome", "marks", "lap_time", "penalty", "said")
HERE = Path(__file__).resolve().parent
WORLD = "bwrap --die-with-parent --unshare-net --unshare-pid --dev-bind / / --proc /proc".split()
if os.geteuid() == 0:  # whose /proc bwrap covers in part; DRIVER's needs a whole one above it
    WORLD += ["sh", "-c", 'mount -t proc proc /proc && exec "$@"', "sh"]
DRIVER = "bwrap --die-with-parent --unshare-all --share-net --uid 65534 --gid 65534 --clearenv"
PROGRAMS = ("/bin", "/lib", "/lib64", "/sbin", "/usr", "/opt/ros")
SETTINGS = ("alternatives", "hosts", "ld.so.cache", "localtime", "nsswitch.conf", "passwd")
OF_PADDOCK = (".venv", "commands", "config", "devel", "src")
VARIABLES = ("PATH", "LANG", "LC_ALL", "LD_LIBRARY_PATH", "OPENBLAS_NUM_THREADS", "VIRTUAL_ENV")
VARIABLES += ("CMAKE_PREFIX_PATH", "PYTHONPATH", "PYTHONNOUSERSITE", "PYTHONUNBUFFERED")
PROCESSES, PRINTED, FILES = 400, 10**6, 2**26  # of a driver: number, [bytes], in its /tmp [bytes]
START = 120.0  # wall time until nodes are connected, however slow the computer is [s]
SPARE = 3 * START  # for the start and the end of a world [s]


class Lap:
    """One driver's lap in a world that is up."""

    def __init__(self, task):
        self.task, self.driver, self.status = task, None, None
        rospy.init_node("grade", disable_signals=True)
        rospy.Subscriber("/referee/status", LapStatus, self._judge, queue_size=100)
        for name in ("/gazebo/step", "/gazebo/get_physics_properties", "/referee/restart"):
            rospy.wait_for_service(name, START)
        physics = rospy.ServiceProxy("/gazebo/get_physics_properties", GetPhysicsProperties)
        self.steps = round(PERIOD / physics().time_step)
        self.step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)

    def _judge(self, status):
        if self.status is None or not self.status.laps:  # what comes after the finish counts not
            self.status = status

    def wait(self, done):
        """Waits, in wall time, until done() or START is over; returns whether it is done."""
        for _ in range(round(START / 0.05)):
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
        if not self.wait(lambda: driver.poll() is not None or self.ready()):
            return "did not start"
        rospy.rostime.wallsleep(1.0)  # until what is registered is connected, too
        answers, end = 0, time.monotonic() + self.task["wall_time_limit"]
        for _ in range(round(self.task["time_limit"] / PERIOD)):
            if driver.poll() is not None:
                return "crashed"
            if time.monotonic() > end:
                return "too slow"
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


def enclosed(path):
    """Returns the words before a driver's command: files and variables that it needs, no others."""
    words, root = DRIVER.split(), os.environ["PADDOCK_ROOT"]
    shown = [*PROGRAMS, *(f"/etc/{name}" for name in SETTINGS)]
    for place in (*shown, *(f"{root}/{name}" for name in OF_PADDOCK)):
        link = os.path.islink(place) and not place.startswith("/etc")
        words += ["--symlink", os.readlink(place)] if link else ["--ro-bind-try", place]
        words.append(place)
    words += ["--proc", "/proc", "--dev", "/dev", "--size", str(FILES), "--tmpfs", "/tmp"]
    words += ["--ro-bind", str(path), f"/tmp/{path.name}", "--chdir", "/tmp"]
    for name, value in {**os.environ, "HOME": "/tmp"}.items():
        if name in (*VARIABLES, "HOME") or name.startswith(("ROS_", "PADDOCK_ROOT")):
            words += ["--setenv", name, value]
    return words


def limits(task):
    """Returns the words before a driver's command that limit each of its processes."""
    words = ["prlimit", f"--data={task['memory'] * 10**6}", f"--fsize={PRINTED}"]
    return [*words, f"--nproc={PROCESSES}", f"--cpu={task['wall_time_limit']}"]


def drive(task, path, said, trust):
    """Lets one driver drive in a world of its own.

    Args:
        said: File for what it prints.
        trust: Whether it runs without an enclosure.

    Returns:
        Its row.
    """
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    options = dict(stdin=subprocess.DEVNULL, stderr=subprocess.STDOUT, start_new_session=True)
    launch = ["roslaunch", "-p", str(port), str(HERE / "class.launch"), f"track:={task['track']}"]
    launch.append(f"patience:={task['patience']}")
    running = [subprocess.Popen(launch, stdout=subprocess.DEVNULL, **options)]
    command = [*limits(task), sys.executable, str(path)]
    if not trust:
        command = [*enclosed(path), *limits(task), sys.executable, f"/tmp/{path.name}"]
    try:
        while not rosgraph.is_master_online():
            rospy.rostime.wallsleep(0.1)
        lap = Lap(task)
        with open(said, "wb") as stream:
            running.append(subprocess.Popen(command, stdout=stream, **options))
        outcome = lap.run(running[-1])
        status = lap.status or LapStatus()
    finally:
        for process in reversed(running):
            stop_session(process, 30.0)
    points = marks(task["marks"], task["time_limit"], outcome, status)
    figures = (f"{value:.2f}" for value in (points, status.last_lap_time, status.penalty))
    return dict(zip(COLUMNS, (path.stem, outcome, *figures)))


def grade(given, path, limit):
    """Starts drive() in a process of its own, as a process is one ROS node.

    Args:
        given: The command line's arguments.
        limit: Of the driver's wall time [s].

    Returns:
        The row.
    """
    said = given.marks.with_suffix(f".{path.stem}.txt")
    words = [sys.executable, __file__, *map(str, (given.task, given.folder, given.marks))]
    words += ["--only", str(path), "--said", str(said)]
    words = [*words, "--trust"] if given.trust else [*WORLD, *words]
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, timeout=limit + SPARE)
    row = json.loads(done.stdout.splitlines()[-1])
    lines = said.read_text(errors="replace").strip().splitlines()
    row["said"] = lines[-1][:200] if lines and row["outcome"] != "lap" else ""
    return row


def main():
    """Marks all."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for name in ("task", "folder", "marks"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--trust", action="store_true", help="run drivers with your own rights")
    parser.add_argument("--only", type=Path, help=argparse.SUPPRESS)  # of grade()
    parser.add_argument("--said", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    task = yaml.safe_load(given.task.read_text())
    if given.only:
        print(json.dumps(drive(task, given.only, given.said, given.trust)))
        return
    if not given.trust:
        probe = [*WORLD, *enclosed(HERE / "grade.py"), "true"]
        try:
            done = subprocess.run(probe, capture_output=True, text=True)
            why = done.returncode and done.stderr.strip()
        except FileNotFoundError:
            why = "apt-get install bubblewrap"
        if why:
            sys.exit(f"grade.py: drivers cannot be enclosed: {why}; see --trust")
    with given.marks.open("w", newline="") as stream:
        table = csv.DictWriter(stream, COLUMNS)
        table.writeheader()
        for path in sorted(given.folder.resolve().glob("*.py")):
            row = grade(given, path, task["wall_time_limit"])
            table.writerow(row)
            print(*row.values(), flush=True)


if __name__ == "__main__":
    main()
