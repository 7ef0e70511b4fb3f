"""./run world where the clock is set, the network knows IPv6 alone, or another user has a world."""

import ctypes
import os
import pathlib
import shutil
import socket
import stat
import subprocess
import time

from figures import BenchError

from soaking.stops import World

HOUR = 3600  # [s]
CLOCK = pathlib.Path(__file__).with_name("shifted_clock.c")
NEW_NETWORK = 0x40000000  # CLONE_NEWNET of unshare(2)
OTHER = ("--reuid=nobody", "--regid=nogroup", "--clear-groups")


def must(*command):
    """Runs a command.

    Raises:
        BenchError: It failed, or is not installed.
    """
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except OSError as error:
        raise BenchError(f"{command[0]}: {error.strerror}") from None
    if done.returncode:
        raise BenchError(f"{' '.join(command)}: {done.stderr.strip()}")


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
        trial.world.ask(what="picture")
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
    trial.world.ask(what="picture")
    trial.goes_on()
    return "runs, with Debian's nodes"


class OthersWorld(World):
    """A world of the user nobody, by roslaunch from this clone, which he cannot write.

    Args:
        folder: pathlib.Path for logs.
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
        other.ask(what="picture")
        trial.goes_on()
        other.stop("SIGINT")
        trial.goes_on()
        return "both run; neither sees into the other's temporary files"
    finally:
        other.close()


TRIALS = (clock_set, ipv6_alone, two_users)
