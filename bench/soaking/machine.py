"""./run world on machines that are not as they should be: full disks, small limits, odd homes.

Mounts are made in a mount namespace of their own, so that nothing else sees them; that needs root.
"""

import argparse
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import time

from figures import BenchError

from soaking import setting_up, surroundings, users
from soaking.log import problems
from soaking.stops import World

LIMIT = 20.0  # [s] within which a world that cannot run says so
MIXED_UP = "full_logs"  # where the master's tracebacks run into the lines of other nodes
OURS = 5  # nodes of this repository in the world
ON = 3.0  # [s] for which simulated time has to go on after a fault


class Trial:
    """A world under a condition.

    Args:
        folder: pathlib.Path for everything that the trial writes.
    """

    def __init__(self, folder):
        shutil.rmtree(folder, ignore_errors=True)
        self.folder, self.world = folder, World(folder / "world")
        self.environment = self.world.environment

    def mount(self, path, options):
        """Mounts an empty tmpfs on a directory, in this process's namespace."""
        os.makedirs(path, exist_ok=True)
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(path)]
        subprocess.run(command, check=True)

    def home(self, name):
        """Gives the world a new home directory; returns its path."""
        path = self.folder / name
        path.mkdir(parents=True)
        self.environment["HOME"] = str(path)
        return path

    def up(self):
        """Starts the world and waits for its controllers."""
        self.world.start()
        self.world.reach("running", random.Random(0))

    def goes_on(self):
        """Raises BenchError unless simulated time moves and calls are answered."""
        before = self.world.ask(what="time")["time"]
        time.sleep(ON)
        after = self.world.ask(what="time")["time"]
        if not after > before:
            raise BenchError(f"simulated time stands still at {after:g} s")

    def said(self):
        """What ./run and its nodes have printed."""
        return self.world.said()


def fill(path):
    """Fills the file system of a directory to the last byte."""
    block = b"\0" * 4096
    with open(pathlib.Path(path) / "filler", "wb", buffering=0) as file:
        try:
            while file.write(block):
                pass
        except OSError:
            pass


def full_logs(trial):
    """The disk of the logs runs full while the world runs."""
    logs = trial.environment["ROS_LOG_DIR"]
    trial.mount(logs, "size=4m")
    trial.up()
    fill(logs)
    trial.world.ask(what="wild_calls", seed=1, count=300)
    trial.goes_on()
    said = trial.said().count("the log cannot be written to")
    if not 1 <= said <= OURS:
        raise BenchError(f"a full disk was said {said} times by our nodes")
    return f"said {said} times by our nodes; Debian's master and rosout say it for each line"


def full_temporary(trial):
    """The disk of temporary files is full: models are refused with a sentence."""
    trial.mount(trial.world.temporary, "size=8m")
    trial.up()
    fill(trial.world.temporary)
    answer = trial.world.ask(what="balls", count=1)
    trial.goes_on()
    if not any("cannot be prepared" in text for text in answer["failed"]):
        raise BenchError(f"spawning on a full disk answered {answer['failed']}")
    os.remove(trial.world.temporary / "filler")
    if trial.world.ask(what="balls", count=1)["failed"]:
        raise BenchError("no model can be spawned once there is room again")
    return "refused, goes on, spawns again when there is room"


def read_only_home(trial):
    """The home directory cannot be written."""
    trial.mount(trial.home("home"), "size=1m,ro")
    trial.up()
    trial.goes_on()
    return "runs"


def no_shared_memory(trial):
    """/dev/shm is read-only and empty."""
    trial.mount("/dev/shm", "size=4k,ro")
    trial.up()
    trial.world.ask(what="picture")
    trial.goes_on()
    return "runs, cameras too"


def few_descriptors(trial):
    """512 open files for each process."""
    resource.setrlimit(resource.RLIMIT_NOFILE, (512, 512))
    trial.up()
    trial.world.ask(what="balls", count=10)
    trial.goes_on()
    return "runs"


def private_files(trial):
    """umask 077."""
    os.umask(0o077)
    trial.home("home")
    trial.up()
    trial.goes_on()
    return "runs"


def odd_home(trial):
    """A home with blanks and umlauts."""
    trial.home("Jürgens Häuschen (neu)")
    trial.up()
    trial.goes_on()
    return "runs"


def wrong_hostname(trial):
    """ROS_HOSTNAME names no machine."""
    trial.environment.pop("ROS_IP")
    trial.environment["ROS_HOSTNAME"] = "no-such-machine.invalid"
    trial.world.start()
    try:
        status = trial.world.process.wait(LIMIT)
    except subprocess.TimeoutExpired:
        raise BenchError(f"no word within {LIMIT:g} s") from None
    lines = [line for line in trial.said().splitlines() if "no-such-machine" in line]
    if status == 0 or not lines:
        raise BenchError(f"status {status}, said {trial.said()[-300:]!r}")
    return f"refused with status {status}: {lines[0].strip()}"


TRIALS = {
    trial.__name__: trial
    for trial in (
        full_logs,
        full_temporary,
        read_only_home,
        no_shared_memory,
        few_descriptors,
        private_files,
        odd_home,
        wrong_hostname,
        *surroundings.TRIALS,
        *setting_up.TRIALS,
        *users.TRIALS,
    )
}


def one(name, folder):
    """Runs one trial in this process, which is in a mount namespace of its own.

    Returns:
        Exit status.
    """
    trial = Trial(folder / name)
    try:
        print(TRIALS[name](trial), flush=True)
        tracebacks = problems(trial.said())
        if tracebacks and name != MIXED_UP:
            raise BenchError(f"tracebacks in the log: {tracebacks[0]}")
    except BenchError as error:
        print(error, flush=True)
        return 1
    finally:
        trial.world.close()
    return 0


def run(names, folder, say):
    """Runs trials, each in a process and a mount namespace of its own.

    Args:
        names: Of the trials; none: all.
        folder: pathlib.Path for logs.
        say: Function of a line of progress.

    Returns:
        Names of those that failed.
    """
    failed = []
    for name in names or TRIALS:
        command = ["unshare", "--mount", sys.executable, "-m", "soaking.machine", name, str(folder)]
        done = subprocess.run(
            command,
            cwd=pathlib.Path(__file__).resolve().parents[1],
            stdout=subprocess.PIPE,
            text=True,
        )
        text = done.stdout.strip() or f"exit status {done.returncode}"
        say(f"{TRIALS[name].__doc__} {'FAILED: ' if done.returncode else ''}{text}")
        if done.returncode:
            failed.append(name)
    return failed


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=TRIALS)
    parser.add_argument("folder", type=pathlib.Path)
    options = parser.parse_args()
    sys.exit(one(options.name, options.folder))
