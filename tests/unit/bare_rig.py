"""For the tests of ./run bare: a clone, and a Debian of a shell and five programs in its cache."""

import functools
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time

import run_rig
from run_rig import PATIENCE

PROGRAMS = ("bash", "sleep", "cat", "mkdir", "ls")  # of the machine
FOLDERS = ("proc", "sys", "dev", "tmp", "root", "etc", "var/cache/apt/archives")
NO_MOUNTS = "needs the right to mount and to chroot, which root has not here"
NO_ROOT = "needs root (for mmdebstrap, mount and chroot)"

# What stands in for programs of this machine; MARK is an environment variable.
MMDEBSTRAP = 'mkdir "$TMPDIR/proc" && mount -t proc proc "$TMPDIR/proc" && : >"$MARK" && sleep 1000'
GIT = '[ "$1" != clone ] || cp -r "$4" "$5"'  # where none is installed


@functools.lru_cache(maxsize=None)
def refusal():
    """Gives what ./run bare says where it cannot work; empty if it can.

    It is asked in a clone: the project itself may be an unpacked archive.
    """
    with tempfile.TemporaryDirectory() as folder:
        root = run_rig.small_clone(pathlib.Path(folder) / "clone")
        (root / ".git").mkdir(exist_ok=True)
        done = run_rig.run("bare", "--check", root=root)
    return done.stderr if done.returncode else ""


def where_it_works(test):
    """Runs a test where root may mount; elsewhere what is tested is the refusal."""

    @functools.wraps(test)
    def either(*arguments, **options):
        if not refusal():
            test(*arguments, **options)
        else:
            assert NO_ROOT in refusal() or NO_MOUNTS in refusal()

    return either


class Bare:
    """A small clone, its cache, and programs that come before those of this machine.

    Attributes:
        mark: A file that a stand-in makes when it works.
    """

    def __init__(self, folder):
        self.root = run_rig.small_clone(folder / "paddock")
        (self.root / ".gitignore").write_text(".cache/\n__pycache__/\n/out/\n/test-results/\n")
        self.cache = folder / "cache" / "paddock" / "bare"
        self.mark = folder / "mark"
        self._programs = folder / "programs"
        for path in (self.cache, self._programs):
            path.mkdir(parents=True)
        self.program("mmdebstrap", MMDEBSTRAP)
        if shutil.which("git"):
            name = ("-c", "user.name=probe", "-c", "user.email=probe@example.org")
            for words in (("init", "-q"), ("add", "."), (*name, "commit", "-qm", "Probe")):
                subprocess.run(["git", *words], cwd=self.root, check=True)
        else:
            (self.root / ".git").mkdir()
            self.program("git", GIT)

    def program(self, name, text):
        """Puts a shell script in front of a program of this machine."""
        run_rig.program(self._programs / name, f"#!/bin/sh\n{text}\n")

    def tarball(self, suite="bookworm"):
        """Puts the Debian of a few programs where ./run bare keeps it."""
        folder = self.cache.parent / "tiny"
        for name in FOLDERS:
            (folder / name).mkdir(parents=True)
        for name in PROGRAMS:
            put(folder, shutil.which(name), f"/bin/{name}")
        put(folder, shutil.which("bash"), "/bin/sh")
        subprocess.run(["tar", "-cf", self.cache / f"{suite}.tar", "-C", folder, "."], check=True)
        shutil.rmtree(folder)
        return self

    def environment(self, **more):
        """Gives the environment in which ./run is started."""
        path = f"{self._programs}:{os.environ['PATH']}"
        base = self.cache.parent.parent
        return {**os.environ, "XDG_CACHE_HOME": str(base), "PATH": path, "MARK": str(self.mark),
                **more}  # fmt: skip

    def run(self, *arguments, **more):
        """Runs ./run bare to its end."""
        return run_rig.run("bare", *arguments, root=self.root, env=self.environment(**more))

    def start(self, *arguments, **options):
        """Starts ./run bare with pipes."""
        return run_rig.start("bare", *arguments, root=self.root, env=self.environment(), **options)

    def marked(self, process):
        """Waits for a stand-in to work."""
        while not self.mark.exists():
            assert process.poll() is None, process.communicate()[0]
            time.sleep(0.01)

    def stopped(self, process, number=signal.SIGINT):
        """Sends a signal again and again until ./run has ended.

        Returns:
            (exit status, what it printed).
        """
        while process.poll() is None:
            process.send_signal(number)
            time.sleep(0.05)
        return process.returncode, process.communicate(timeout=PATIENCE)[0]

    def left(self):
        """Lists what is left of machines: folders, mounts and processes."""
        found = [str(path) for path in self.cache.glob("machine-*")]
        found += [str(path) for path in (self.root / ".cache").glob("bare-*")]
        mounts = pathlib.Path("/proc/self/mounts").read_text()
        found += [line for line in mounts.splitlines() if str(self.cache) in line]
        return found + self.processes()

    def processes(self):
        """Lists the processes of machines: by their root, or by a folder on their command line."""
        found = run_rig.processes_of(self.cache)
        for link in pathlib.Path("/proc").glob("[0-9]*/root"):
            try:
                target = os.readlink(link)
            except OSError:
                continue
            if target.startswith(str(self.cache)):
                found.append(target)
        return found


def put(folder, program, there):
    """Puts a program with the libraries that it is linked to into another root folder."""
    listed = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    for source, target in [(program, there)] + [
        (path, path) for path in re.findall(r"(/\S+) \(0x", listed)
    ]:
        place = pathlib.Path(f"{folder}{target}")
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, place)
