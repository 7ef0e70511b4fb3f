"""./run setup in a clone of its own, interrupted again and again until it has got through."""

import itertools
import pathlib
import shutil
import signal
import subprocess
import time

from figures import BenchError
from processes import arguments_of

from soaking.crowd import Crowd
from soaking.marked import marked, wait_none
from soaking.session import BENCH

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


def command(world, clone, *words):
    """Runs ./run of a clone to its end.

    Raises:
        BenchError: It failed.
    """
    environment = {**world.environment, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [str(clone / "run"), *words],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LIMIT,
    )
    if done.returncode:
        text = (done.stdout + done.stderr)[-1000:]
        raise BenchError(f"./run {' '.join(words)}: exit status {done.returncode}: {text}")
    return done.stdout


def attempt(world, clone, seconds, number):
    """Starts ./run setup and interrupts it.

    Args:
        world: Subject that starts it.
        clone: pathlib.Path.
        seconds: When, on a machine with nothing else to do.
        number: The signal.

    Returns:
        Whether it was done before.

    Raises:
        BenchError: It failed, or did not end.
    """
    if number != signal.SIGKILL:  # what a killed one has left at work is not this one's
        wait_none(world.mark, LIMIT)
    process, crowd, begin = world.popen(str(clone / "run"), "setup"), Crowd(), time.monotonic()
    while process.poll() is None and time.monotonic() - begin < seconds * crowd.slowdown():
        crowd.look(marked(world.mark))
        time.sleep(0.05)
    if process.poll() is None:
        process.send_signal(number)
        if number == signal.SIGKILL:  # what it has started may go on; the next one waits for that
            process.wait()
            return False
        end = time.monotonic() + END_LIMIT * crowd.slowdown()
        while left := marked(world.mark):
            if time.monotonic() > end:
                names = [" ".join(arguments_of(pid))[:160] for pid in left]
                raise BenchError(f"{number.name} after {seconds:g} s: left {names}")
            time.sleep(0.05)
        process.wait()
    if process.returncode not in (0, 128 + number, -number):
        said = world.said()[-1000:]
        raise BenchError(f"exit status {process.returncode} after {number.name}: {said}")
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
    project, _, version = name.removesuffix(".dist-info").partition("-")
    return f"{project.replace('_', '-')}=={version}" in text.replace("_", "-")


TRIALS = (setup_interrupted,)
