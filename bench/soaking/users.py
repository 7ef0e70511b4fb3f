"""./run started as a user of his own clone: with the right to use sudo, without it, beside root.

The user, sudo and a package exist in an overlay of the file system alone, which the trial's mount
namespace keeps from everything else.
"""

import os
import shutil
import subprocess

from figures import BenchError

from soaking.setting_up import LIMIT, WORKS, copy
from soaking.stops import World

NAME, NUMBER = "paddock-trial", 61234  # user and group
PACKAGE = "hello"  # of Debian; small, and nobody needs it
AS_USER = ("setpriv", f"--reuid={NUMBER}", f"--regid={NUMBER}", "--clear-groups")
OVERLAID = ("/etc", "/usr", "/var")
APT = ("apt-get", "-y", "-q", "--no-install-recommends")


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


def overlay(trial):
    """Lets changes of the system go to a folder that goes with the trial."""
    layers = trial.folder / "layers"
    trial.mount(layers, "size=1g")
    for path in OVERLAID:
        upper, work = layers / f"upper{path}", layers / f"work{path}"
        upper.mkdir(parents=True)
        work.mkdir(parents=True)
        options = f"lowerdir={path},upperdir={upper},workdir={work}"
        must("mount", "-t", "overlay", "overlay", "-o", options, path)


def add_user(trial, clone):
    """Adds the user, who gets a home and the clone; returns his environment."""
    home = trial.folder / "home"
    home.mkdir()
    for path in (home, clone):
        must("chown", "-R", f"{NUMBER}:{NUMBER}", str(path))
    must("groupadd", "--gid", str(NUMBER), NAME)
    ids = ("--uid", str(NUMBER), "--gid", str(NUMBER))
    must("useradd", "--no-create-home", "--home-dir", str(home), "--shell", "/bin/bash", *ids, NAME)
    kept = {name: value for name, value in trial.environment.items() if not name.startswith("XDG")}
    kept.pop("TMPDIR")
    return {**kept, "HOME": str(home), "USER": NAME, "LOGNAME": NAME, "PATH": os.defpath}


def setup(clone, environment):
    """./run setup as the user; returns exit status, stdout and stderr."""
    command = [*AS_USER, str(clone / "run"), "setup"]
    options = {"stdin": subprocess.DEVNULL, "capture_output": True, "text": True}
    done = subprocess.run(command, env=environment, timeout=LIMIT, check=False, **options)
    return done.returncode, done.stdout, done.stderr


def refused(clone, environment, reason):
    """Raises BenchError unless ./run setup says which package is missing and why it stays so."""
    status, said, error = setup(clone, environment)
    advice = f"As root: apt-get install --no-install-recommends {PACKAGE}"
    if status != 1 or reason not in error or advice not in error or "Traceback" in said + error:
        raise BenchError(f"without the right to install: status {status}, {said}{error}")


class UsersWorld(World):
    """A world of the user, from his clone.

    Args:
        folder: pathlib.Path for logs.
        clone: His, set up.
        temporary: Folder of temporary files that he shares.
        environment: His variables.
    """

    def __init__(self, folder, clone, temporary, environment):
        super().__init__(folder)
        own = {name: environment[name] for name in ("HOME", "USER", "LOGNAME", "PATH")}
        self.environment.update(own, TMPDIR=str(temporary))
        self.environment.pop("XDG_RUNTIME_DIR", None)
        self._clone = clone
        must("chown", "-R", f"{NUMBER}:{NUMBER}", str(folder))

    def start(self):
        """Starts ./run world of his clone."""
        self.process = self.popen(*AS_USER, str(self._clone / "run"), "world")


def beside_root(trial, clone, environment):
    """Root's world and the user's, at the same time, from two clones."""
    trial.world.temporary.chmod(0o1777)
    other = UsersWorld(trial.folder / "other", clone, trial.world.temporary, environment)
    try:
        trial.world.start()
        other.start()
        trial.world.reach("running", None)
        other.reach("running", None)
        other.ask(what="picture")
        other.stop("SIGINT")
        trial.goes_on()
    finally:
        other.close()


def other_user(trial):
    """A user with his own clone: no sudo, without the right to use it, with it; beside root."""
    overlay(trial)
    for path in ("sudo", PACKAGE):
        if shutil.which(path):
            must(*APT, "remove", path)
    clone = copy(trial.folder / "clone")
    environment = add_user(trial, clone)
    wanted = clone / "config" / "apt.txt"
    before = wanted.read_text()
    wanted.write_text(f"{before}{PACKAGE}\n")
    refused(clone, environment, "nor is there a sudo")
    must(*APT, "update")
    must(*APT, "install", "sudo")
    refused(clone, environment, "sudo refused")
    wanted.write_text(before)  # nothing is missing now, nothing asks for sudo
    for words in (["setup"], *WORKS):
        must(*AS_USER, str(clone / "run"), *words, env=environment)
    wanted.write_text(f"{before}{PACKAGE}\n")
    rule = trial.folder / "rule"
    rule.write_text(f"{NAME} ALL=(ALL) NOPASSWD: ALL\n")
    must("install", "-m", "440", str(rule), "/etc/sudoers.d/paddock-trial")
    status, said, error = setup(clone, environment)
    if status or shutil.which(PACKAGE) is None:
        raise BenchError(f"with sudo: status {status}, {said}{error}")
    beside_root(trial, clone, environment)
    must("rm", "-r", str(clone))
    return "sentences without the right, set up with it; his world and root's do not collide"


TRIALS = (other_user,)
