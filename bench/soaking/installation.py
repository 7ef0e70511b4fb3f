"""./run setup in a clone of its own: interrupted again and again, and as a user of his own.

That user has the right to use sudo or not, and a world at the same time as root. He, sudo and a
package exist in an overlay of the file system alone, which the trial's mount namespace keeps from
everything else.
"""

import itertools
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time

from figures import BenchError
from launching import BENCH
from usage import procfs

from soaking.limits import CompetingLoad
from soaking.shutdown import World

ROOT = BENCH.parent
NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
STEP = 1.0  # [s] from one moment of interruption to the next, on a machine with nothing else to do
END_LIMIT = 15.0  # [s] from SIGINT or SIGTERM to the end: pip and make get 5 s of it
LIMIT = 1800.0  # [s] for a set-up that nobody interrupts
NOT_COPIED = (".git", ".venv", ".cache", "build", "devel", "out", "out-fresh", "test-results")
WORKS = (
    ("version",),
    ("exec", "python", "-c", "import pybullet, cv2, gazebo_msgs.srv"),
    ("exec", "roslaunch", "--files", "track_model", "world.launch"),
)
NAME, NUMBER = "paddock-trial", 61234  # user and group
PACKAGE = "hello"  # of Debian; small, and nobody needs it
AS_USER = ("setpriv", f"--reuid={NUMBER}", f"--regid={NUMBER}", "--clear-groups")
OVERLAID = ("/etc", "/usr", "/var")
APT = ("apt-get", "-y", "-q", "--no-install-recommends")


def copy(folder):
    """Copies this clone without what a set-up makes; returns the folder."""

    def ignored(path, names):
        here = pathlib.Path(path) == ROOT
        return [n for n in names if n == "__pycache__" or (here and n in NOT_COPIED)]

    shutil.copytree(ROOT, folder, symlinks=True, ignore=ignored)
    (folder / "src" / "CMakeLists.txt").unlink(missing_ok=True)  # catkin_make's
    return folder


def generated(root):
    """What a set-up of a clone makes: Python packages, generated code, files of devel.

    Returns:
        dict of path -> text of what is generated, '' of other files.
    """
    found = {path.name: "" for path in root.glob(".venv/lib/python3*/site-packages/*.dist-info")}
    for path in (root / "devel").rglob("*"):
        name = str(path.relative_to(root))
        if path.is_dir() or "__pycache__" in name or "egg-info" in name:
            continue
        code = path.suffix in (".py", ".h", ".js", ".lisp", ".l") and not path.is_symlink()
        text = path.read_text(errors="replace") if code else ""
        found[name] = text.replace(str(root), "ROOT")
    return found


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


def command(world, clone, *words):
    """Runs ./run of a clone to its end; returns what it printed, see must()."""
    environment = {**world.environment, "PYTHONDONTWRITEBYTECODE": "1"}
    return must(str(clone / "run"), *words, env=environment, stdin=subprocess.DEVNULL)


def attempt(world, clone, seconds, number):
    """Starts ./run setup and interrupts it.

    Args:
        world: ProcessesUnderTest that starts it.
        seconds: When, on a machine with nothing else to do.

    Returns:
        Whether it was done before.

    Raises:
        BenchError: It failed, or did not end.
    """
    if number != signal.SIGKILL:  # what a killed one has left at work is not this one's
        world.wait_ended(LIMIT)
    process = world.popen(str(clone / "run"), "setup")
    load, begin = CompetingLoad(), time.monotonic()
    while process.poll() is None and time.monotonic() - begin < seconds * load.slowdown():
        load.sample(world.pids())
        time.sleep(0.05)
    if process.poll() is None:
        process.send_signal(number)
        if number == signal.SIGKILL:  # what it has started may go on; the next one waits for that
            process.wait()
            return False
        end = time.monotonic() + END_LIMIT * load.slowdown()
        while left := world.pids():
            if time.monotonic() > end:
                names = [" ".join(procfs.arguments(pid))[:160] for pid in left]
                raise BenchError(f"{number.name} after {seconds:g} s: left {names}")
            time.sleep(0.05)
        process.wait()
    if process.returncode not in (0, 128 + number, -number):
        text = world.output()[-1000:]
        raise BenchError(f"exit status {process.returncode} after {number.name}: {text}")
    return process.returncode == 0


def setup_interrupted(trial):
    """./run setup is interrupted at each second, by SIGINT, SIGTERM and SIGKILL in turn."""
    command(trial.world, ROOT, "setup")
    clone, count = copy(trial.folder / "clone"), 0
    for count, number in enumerate(itertools.cycle(NUMBERS)):
        if attempt(trial.world, clone, STEP * (count + 1), number):
            break
    for words in WORKS:
        command(trial.world, clone, *words)
    again = command(trial.world, clone, "setup")
    if again != f"ready: {clone}\n":
        raise BenchError(f"a set-up after the set-up said {again!r}")
    expected, found = generated(ROOT), generated(clone)
    later = "".join(path.read_text() for path in (ROOT / "config").glob("requirements-*.txt"))
    wrong = sorted(
        name
        for name in expected
        if expected[name] != found.get(name) and not _is_pinned(name, later)
    )
    if wrong:
        raise BenchError(f"missing, or not as in {ROOT}: {', '.join(wrong[:10])}")
    shutil.rmtree(clone)
    return f"interrupted {count} times, then complete: {len(found)} files as they should be"


def _is_pinned(name, text):
    """Whether a .dist-info is of a package that a requirements' text pins: train brought it."""
    project, _, version = re.sub(r"\.dist-info$", "", name).partition("-")
    return f"{project.replace('_', '-')}=={version}" in text.replace("_", "-")


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


def with_root(trial, clone, environment):
    """Root's world and the user's, at the same time, from two clones."""
    trial.world.temporary.chmod(0o1777)
    other = UsersWorld(trial.folder / "other", clone, trial.world.temporary, environment)
    try:
        trial.world.start()
        other.start()
        trial.world.reach("running", None)
        other.reach("running", None)
        other.ask(what="image")
        other.stop("SIGINT")
        trial.goes_on()
    finally:
        other.close()


def other_user(trial):
    """A user with his own clone: no sudo, without the right to use it, with it; beside root's."""
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
    with_root(trial, clone, environment)
    must("rm", "-r", str(clone))
    return "sentences without the right, set up with it; his world and root's do not collide"


TRIALS = (setup_interrupted, other_user)
