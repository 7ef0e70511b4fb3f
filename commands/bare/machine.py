"""A bare machine: its folder, what is kept between runs, programs in it, and its end.

In the cache folder (`bare/`) are SUITE.tar (what debootstrap made), apt/, pip/ and wheels/ (what
was downloaded or compiled), and machine-*/ of the runs that are going on, each locked by its run.
All of it can be deleted while none is. A machine whose run was killed goes with the next start.

At its end there is no process in it, no mount in it, no folder. In namespaces of its own there is
nothing left to end or to unmount, whatever became of ./run. Where the kernel refuses those, both
are done here. A folder with a mount in it is never removed.
"""

import contextlib
import errno
import fcntl
import glob
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile

from commands import processes
from commands.bare import host
from commands.bare.inside import SIGNALS
from commands.bare.removal import remove
from commands.errors import CommandError, Interrupted, say
from commands.paths import CACHE, ROOT, SYSTEM_PATH, read, write

INSIDE = os.path.join(os.path.dirname(__file__), "inside.py")
ISOLATED = ("unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc")
PROJECT = "/project"  # in the machine
ARCHIVES = "/var/cache/apt/archives"
STAGED = os.path.join(CACHE, "bare-")  # results on their way, with the machine's name behind it
GRACE = 3.0  # for a program to end after SIGINT, before everything is killed [s]
F_SETPIPE_SZ = 1031  # of fcntl, which has it from Python 3.10
POLL = 0.2  # between looks whether another run has made the Debian [s]
TAIL = 15  # lines of debootstrap's log that are shown if it fails


def cache_folder():
    """Returns the folder of what is kept between runs."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):
        base = os.path.join(os.path.expanduser("~"), ".cache")
    return os.path.join(os.path.realpath(base), "paddock", "bare")


class Machine:
    """A Debian in a folder, for one run; within a with statement, after which it is gone."""

    def __init__(self, suite, isolated):
        """Prepares a machine; nothing is made before the with statement.

        Args:
            isolated: Whether namespaces of its own are to be had.
        """
        self._suite, self._isolated = suite, isolated
        self._cache = cache_folder()
        self._signals = processes.Signals()
        self._binds = []

    def __enter__(self):
        self._signals.__enter__()
        try:
            os.makedirs(self._cache, exist_ok=True)
            with _locked(os.path.join(self._cache, "lock")):
                abandoned = self._abandoned()
                self._folder = tempfile.mkdtemp(prefix="machine-", dir=self._cache)
                self._lock = _lock(self._folder)
        except BaseException:
            self._signals.__exit__()
            raise
        self.root = os.path.join(self._folder, "root")
        self._staged = STAGED + os.path.basename(self._folder)
        try:
            for folder, lock in abandoned:
                say(f"bare: removing {folder}, which a killed run has left")
                remove(folder)
                os.close(lock)
            self._signals.check()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        try:
            try:
                if self._signals.first is not None:
                    with contextlib.suppress(OSError):  # the terminal may be gone
                        say("bare: interrupted, removing the machine")
                self._keep()
            finally:
                shutil.rmtree(self._staged, ignore_errors=True)
                remove(self._folder)
        finally:
            os.close(self._lock)
            self._signals.__exit__()
        self._signals.check()

    def make(self):
        """Puts the Debian and the committed state of this clone into the folder.

        Raises:
            CommandError: debootstrap, tar or git failed.
            Interrupted: A signal ended it.
        """
        os.mkdir(self.root)
        os.chmod(self.root, 0o755)
        base = os.path.join(self._cache, f"{self._suite}.tar")
        with _locked(f"{base}.lock", self._signals, "another ./run bare makes this Debian"):
            if not os.path.exists(base):
                self._bootstrap(base)
            else:
                self._tool(["tar", "--numeric-owner", "-xpf", base, "-C", self.root])
        self._clone()
        self._furnish()

    def run(self, words):
        """Runs a program in the machine, in the project's folder, with its output shown.

        Args:
            words: Program and arguments; a single one is a line of bash.

        Returns:
            Its exit status, as a shell gives it.

        Raises:
            Interrupted: A signal ended it.
        """
        argv = ["/bin/bash", "-c", words[0]] if len(words) == 1 else words
        return self._start(argv, PROJECT, host.environment(), root=self.root, binds=self._binds)

    def copy_results(self, destinations, mark):
        """Copies what the project's commands have left.

        Args:
            destinations: Dict of a folder's name in the project -> where it goes; what is there is
                replaced.
            mark: (name, text) of a file that is put into each.
        """
        for name, there in destinations.items():
            left = f"{self.root}{PROJECT}/{name}"
            if os.path.isdir(left) and not os.path.islink(left):
                write(os.path.join(left, mark[0]), mark[1])
                os.makedirs(self._staged, exist_ok=True)
                staged = os.path.join(self._staged, name)
                self._tool(["cp", "-r", "--no-dereference", "--preserve=timestamps", left, staged])
                if os.path.lexists(there):
                    shutil.rmtree(there)
                os.makedirs(os.path.dirname(there), exist_ok=True)
                os.rename(staged, there)

    def _abandoned(self):
        """Lists (folder, lock) of machines whose run has ended without removing them."""
        found = []
        for folder in glob.glob(os.path.join(self._cache, "machine-*")):
            lock = _lock(folder)
            if lock is not None:
                found.append((folder, lock))
        for staged in glob.glob(f"{STAGED}machine-*"):
            if not os.path.isdir(os.path.join(self._cache, staged[len(STAGED) :])):
                shutil.rmtree(staged, ignore_errors=True)
        return found

    def _bootstrap(self, base):
        """Makes the Debian, and keeps it as a tarball."""
        mirror, log = host.mirror(), os.path.join(self._cache, f"debootstrap-{self._suite}.log")
        say(f"bare: making Debian {self._suite} with debootstrap, once (details in {log})")
        command = ["debootstrap", "--variant=minbase", self._suite, self.root, mirror]
        with open(log, "wb") as stream:
            environ = _with_system_path(host.for_debootstrap())
            status = self._start(
                command, "/", environ, stdout=stream, stderr=stream, stdin=subprocess.DEVNULL
            )
        if status != 0:
            raise CommandError(
                f"debootstrap made no Debian {self._suite} from {mirror} (exit status {status})",
                f"The end of {log}:",
                *(f"| {line}" for line in read(log).splitlines()[-TAIL:]),
            )
        for path in glob.glob(f"{self.root}{ARCHIVES}/*.deb"):
            os.remove(path)
        part = os.path.join(self._folder, "base.tar")
        self._tool(["tar", "--numeric-owner", "-cf", part, "-C", self.root, "."])
        os.replace(part, base)

    def _clone(self):
        """Clones what is committed; whoever owns this clone."""
        settings = os.path.join(self._folder, "gitconfig")
        write(settings, "[safe]\n\tdirectory = *\n")
        environ = {name: value for name, value in os.environ.items() if name[:4] != "GIT_"}
        environ.update(GIT_CONFIG_GLOBAL=settings, GIT_CONFIG_NOSYSTEM="1")
        clone = ["git", "clone", "--quiet", "--no-local", ROOT, self.root + PROJECT]
        self._tool(clone, environ)

    def _furnish(self):
        """Writes the settings of the network, puts in what earlier runs have downloaded."""
        folders = host.take_over(self.root, self._suite)
        self._binds = [(path, path, False) for path in folders]
        pip = os.path.join(self._cache, "pip")
        os.makedirs(pip, exist_ok=True)
        self._binds.append((pip, "/root/.cache/pip", True))
        for kept, there, _suffix, put in self._kept():
            os.makedirs(there, exist_ok=True)
            for path in glob.glob(os.path.join(kept, "*")):
                put(path, os.path.join(there, os.path.basename(path)))

    def _kept(self):
        """Lists (folder in the cache, folder of the machine, suffix, function that copies)."""
        wheels = f"{self.root}{PROJECT}/.cache/wheels"
        return (
            (f"{self._cache}/apt/{self._suite}", self.root + ARCHIVES, ".deb", _link),
            (f"{self._cache}/wheels", wheels, ".whl", shutil.copyfile),
        )

    def _keep(self):
        """Keeps the packages that were downloaded and the wheels that were compiled."""
        for kept, there, suffix, put in self._kept():
            for path in glob.glob(os.path.join(there, f"*{suffix}")):
                target = os.path.join(kept, os.path.basename(path))
                whole = suffix == ".deb" or zipfile.is_zipfile(path)  # apt moves only whole ones
                if whole and not os.path.islink(path) and not os.path.exists(target):
                    os.makedirs(kept, exist_ok=True)
                    part = os.path.join(self._folder, os.path.basename(path))
                    put(path, part)
                    os.replace(part, target)

    def _tool(self, argv, environ=None):
        """Runs a program of this machine that has to succeed."""
        status = self._start(argv, "/", _with_system_path(environ or os.environ))
        if status != 0:
            raise CommandError(f"{' '.join(argv)} failed (exit status {status})")

    def _start(self, argv, directory, environ, root=None, binds=(), **popen):
        """Runs a program in namespaces of its own, which end with it and with ./run.

        Returns:
            Its exit status, as a shell gives it.

        Raises:
            Interrupted: A signal ended it.
        """
        task = {
            "argv": argv,
            "directory": directory,
            "environ": dict(environ),
            "root": root,
            "binds": list(binds),
            "isolated": self._isolated,
            "folder": self._folder,
            "clone": ROOT,
        }
        self._signals.check()
        reader, writer = os.pipe()
        try:
            line = json.dumps(task).encode() + b"\n"
            fcntl.fcntl(writer, F_SETPIPE_SZ, max(65536, len(line)))
            os.write(writer, line)
            status = processes.run_child(
                [*(ISOLATED if self._isolated else ()), sys.executable, "-I", "-S", INSIDE]
                + [str(reader)],
                grace=GRACE,
                tick=self._signals.hand_on,
                pass_fds=(reader, self._lock),
                preexec_fn=_block,
                env=_with_system_path(os.environ),
                **popen,
            )
        except Interrupted as interruption:
            self._signals.first = interruption.status - 128
            raise
        finally:
            os.close(writer)
            os.close(reader)
        self._signals.check()
        return processes.exit_status(status)


def isolation():
    """Finds out what the kernel grants to root here.

    Returns:
        True for namespaces of its own, False for mounts alone, None for neither.
    """
    environ = _with_system_path(os.environ)
    probe = ["sh", "-c", 'mount -t tmpfs tmpfs "$1" && chroot / true', "sh"]
    with processes.Signals() as signals, tempfile.TemporaryDirectory() as folder:
        answer = None
        for words in (ISOLATED, ()):
            done = subprocess.run(
                [*words, *probe, folder], env=environ, capture_output=True, start_new_session=True
            )
            subprocess.run(["umount", folder], env=environ, stderr=subprocess.DEVNULL)
            if done.returncode == 0:
                answer = bool(words)
                break
    signals.check()
    return answer


def _block():
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)


def _with_system_path(environ):
    return {**environ, "PATH": f"{environ.get('PATH', '')}:{SYSTEM_PATH}".lstrip(":")}


def _link(path, target):
    """Links a file, or copies it: without namespaces the machine's folder is a mount of its own."""
    if os.path.exists(target):
        return
    try:
        os.link(path, target)
    except OSError as error:
        if error.errno != errno.EXDEV:
            raise
        shutil.copyfile(path, target)


def _lock(folder):
    """Locks a machine; gives the file descriptor that holds it, None if a run does."""
    try:
        opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(opened)
        return None
    return opened


class _locked:  # noqa: N801 - reads as a function
    """Holds the lock of a file within a with statement; tells if it has to wait."""

    def __init__(self, path, signals=None, why=None):
        self._path, self._signals, self._why = path, signals, why

    def __enter__(self):
        self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
        told = self._why is None
        while True:
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return self
            except BlockingIOError:
                if not told:
                    say(f"bare: {self._why}, waiting for it")
                told = True
                if self._signals is not None and self._signals.first is not None:
                    os.close(self._file)
                    self._signals.check()
                time.sleep(POLL)

    def __exit__(self, *_):
        os.close(self._file)
