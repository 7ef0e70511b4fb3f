"""./run world in other environments: full disks, small limits, unusual homes and clocks.

Mounts are made in a mount namespace of their own, so that nothing else sees them; that needs root.
"""

import argparse
import ctypes
import os
import pathlib
import random
import resource
import shutil
import socket
import stat
import subprocess
import sys
import time

from figures import BenchError
from launching import BENCH

from soaking.monitor import problems
from soaking.shutdown import World

HOUR = 3600  # [s]
CLOCK = pathlib.Path(__file__).with_name("shifted_clock.c")
NEW_NETWORK = 0x40000000  # CLONE_NEWNET of unshare(2)
OTHER = ("--reuid=nobody", "--regid=nogroup", "--clear-groups")
LIMIT = 20.0  # [s] within which a world that cannot run says so
MIXED_UP = "full_logs"  # where the master's tracebacks run into the lines of other nodes
OURS = 5  # nodes of this repository in the world
ON = 3.0  # [s] for which simulated time has to go on after a fault


def must(*words, **options):
    """Runs a command.

    Raises:
        BenchError: It failed, or is not installed.
    """
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=LIMIT, **options)
    except OSError as error:
        raise BenchError(f"{words[0]}: {error.strerror}") from None
    if done.returncode:
        raise BenchError(f"{' '.join(words)}: {(done.stdout + done.stderr).strip()[-1000:]}")
    return done.stdout


def clock_set(trial):
    """The machine's clock is set back by an hour, then two hours ahead."""
    library, shift = trial.folder / "clock.so", trial.folder / "shift"
    must("cc", "-shared", "-fPIC", "-o", str(library), str(CLOCK), "-ldl")
    shift.write_text("0")
    trial.environment.update(LD_PRELOAD=str(library), SHIFTED_CLOCK=str(shift))
    trial.up()
    for seconds in (-HOUR, HOUR):
        shift.write_text(str(seconds))
        begin, before = time.monotonic(), trial.world.ask(what="time")["time"]
        trial.goes_on()
        trial.world.ask(what="image")
        gone = trial.world.ask(what="time")["time"] - before
        passed = time.monotonic() - begin
        if not 0.0 < gone < passed + 1.0:  # real time is what it aims at
            raise BenchError(f"{gone:.1f} s of simulated time in {passed:.1f} s")
    return "time goes on at its pace, cameras too"


def ipv6_alone(trial):
    """The network has ::1 alone, and ROS_IPV6 is on."""
    name = socket.gethostname()
    if ctypes.CDLL(None, use_errno=True).unshare(NEW_NETWORK):
        raise BenchError(f"no network of its own: {os.strerror(ctypes.get_errno())}")
    must("ip", "link", "set", "lo", "up")
    must("ip", "address", "del", "127.0.0.1/8", "dev", "lo")
    hosts = trial.folder / "hosts"
    hosts.write_text(f"::1 localhost {name}\n")
    must("mount", "--bind", str(hosts), "/etc/hosts")
    trial.environment.pop("ROS_IP")
    uri = f"http://{name}:{trial.world.port}"
    trial.environment.update(ROS_IPV6="on", ROS_HOSTNAME=name, ROS_MASTER_URI=uri)
    trial.up()
    trial.world.ask(what="image")
    trial.goes_on()
    return "runs, with Debian's nodes"


class OthersWorld(World):
    """A world of the user nobody, by roslaunch from this clone, which he cannot write.

    Args:
        temporary: Folder of temporary files that he shares.
    """

    def __init__(self, folder, temporary):
        super().__init__(folder)
        home = folder / "home"
        home.mkdir()
        self.environment.update(HOME=str(home), TMPDIR=str(temporary))
        for name in ("ROS_HOME", "XDG_CACHE_HOME", "XDG_RUNTIME_DIR"):
            self.environment.pop(name, None)
        for path in (folder, home):
            shutil.chown(path, "nobody", "nogroup")

    def start(self):
        """Starts it."""
        launch = ("roslaunch", "-p", str(self.port), "track_model", "world.launch")
        self.process = self.popen("setpriv", *OTHER, *launch)


def two_users(trial):
    """Another user starts a world from the same clone, with the same folder of temporary files."""
    trial.world.temporary.chmod(0o1777)
    trial.up()
    other = OthersWorld(trial.folder / "other", trial.world.temporary)
    try:
        other.start()
        other.reach("running", None)
        owners = {}
        for path in trial.world.temporary.iterdir():
            found = path.lstat()
            owners.setdefault(found.st_uid, []).append(path.name)
            if stat.S_IMODE(found.st_mode) & 0o077 and not stat.S_ISLNK(found.st_mode):
                raise BenchError(f"others may see into {path}")
        if len(owners) != 2:
            raise BenchError(f"temporary files are {owners}, which is not of two users")
        other.ask(what="image")
        trial.goes_on()
        other.stop("SIGINT")
        trial.goes_on()
        return "both run; neither sees into the other's temporary files"
    finally:
        other.close()


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
        """Makes a new home directory of the world; returns its path."""
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

    def output(self):
        """What ./run and its nodes have printed."""
        return self.world.output()


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
    trial.world.ask(what="fuzzed_calls", seed=1, count=300)
    trial.goes_on()
    said = trial.output().count("the log cannot be written to")
    if not 1 <= said <= OURS:
        raise BenchError(f"a full disk was said {said} times by our nodes")
    return f"said {said} times by our nodes; Debian's master and rosout say it for each line"


def full_temporary(trial):
    """The disk of temporary files is full: models are refused with a message."""
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
    trial.world.ask(what="image")
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
    lines = [line for line in trial.output().splitlines() if "no-such-machine" in line]
    if status == 0 or not lines:
        raise BenchError(f"status {status}, said {trial.output()[-300:]!r}")
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
        clock_set,
        ipv6_alone,
        two_users,
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
        tracebacks = problems(trial.output())
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
        say: Function of a line of progress.

    Returns:
        Names of those that failed.
    """
    failed = []
    for name in names or TRIALS:
        command = [
            "unshare",
            "--mount",
            sys.executable,
            "-m",
            "soaking.environments",
            name,
            str(folder),
        ]
        done = subprocess.run(
            command,
            cwd=BENCH,
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
