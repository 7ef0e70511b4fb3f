"""A bare machine: its folder, what is kept between runs, programs in it, and its end.

In the cache folder (`bare/`) are SUITE.tar (what mmdebstrap made), apt/, pip/ and wheels/ (what was
downloaded or compiled), and machine-*/ of the runs that are going on, each locked by its run. All
of it can be deleted while none is. A machine whose run was killed goes with the next start.

Every program that works in it or for it is started by bubblewrap, in namespaces of its own: when
./run ends, even by SIGKILL, the kernel ends the processes and drops the mounts with it.
"""

import contextlib
import fcntl
import glob
import os
import shutil
import subprocess
import tempfile
import time
import zipfile

from commands import processes
from commands.bare import host
from commands.errors import CommandError, say
from commands.paths import CACHE, ROOT, SYSTEM_PATH, tail, write

ISOLATED = ("bwrap", "--die-with-parent", "--unshare-pid")
PROJECT = "/project"  # in the machine
ARCHIVES = "/var/cache/apt/archives"
STAGED = os.path.join(CACHE, "bare-results")  # on their way
TAIL = 15  # lines of mmdebstrap's log that are shown if it fails
REMOVAL_LIMIT = 20.0  # longest wait for killed processes to be gone [s]


def cache_folder():
    """Returns the folder of what is kept between runs."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):
        base = os.path.join(os.path.expanduser("~"), ".cache")
    return os.path.join(os.path.realpath(base), "paddock", "bare")


class Machine:
    """A Debian in a folder, for one run; within a with statement, after which it is gone."""

    def __init__(self, suite, signals):
        """Prepares a machine; nothing is made before the with statement.

        Args:
            signals: processes.Signals that are noted.
        """
        self._suite, self._signals = suite, signals
        self._cache = cache_folder()
        self._base = os.path.join(self._cache, f"{suite}.tar")

    def __enter__(self):
        os.makedirs(self._cache, exist_ok=True)
        with open(os.path.join(self._cache, "lock"), "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            for folder in glob.glob(os.path.join(self._cache, "machine-*")):
                with contextlib.suppress(BlockingIOError):  # one that is in use
                    os.close(_locked(folder))
                    say(f"bare: removing {folder}, which a killed run has left")
                    _remove(folder)
            self._folder = tempfile.mkdtemp(prefix="machine-", dir=self._cache)
            self._lock = _locked(self._folder)
        self.root = os.path.join(self._folder, "root")
        return self

    def __exit__(self, *_):
        with contextlib.suppress(OSError):  # the terminal may be gone
            if self._signals.first is not None:
                say("bare: interrupted, removing the machine")
        try:
            self._keep()
        finally:
            _remove(self._folder)
        self._signals.check()

    def make(self):
        """Puts the Debian and the committed state of this clone into the folder.

        Raises:
            CommandError: mmdebstrap, tar or git failed.
            Interrupted: A signal ended it.
        """
        if not os.path.exists(self._base):
            self._bootstrap()
        os.mkdir(self.root, 0o755)
        self._tool(["tar", "--numeric-owner", "-xpf", self._base, "-C", self.root])
        settings = os.path.join(self._folder, "gitconfig")  # whoever owns this clone
        write(settings, "[safe]\n\tdirectory = *\n")
        environ = {name: value for name, value in os.environ.items() if name[:4] != "GIT_"}
        environ.update(GIT_CONFIG_GLOBAL=settings, GIT_CONFIG_NOSYSTEM="1")
        clone = ["git", "clone", "--quiet", "--no-local", ROOT, self.root + PROJECT]
        self._tool(clone, env=environ)
        self._shown = host.take_over(self.root, self._suite)
        for kept, there, suffix in self._kept():
            _link(kept, there, suffix)

    def run(self, words):
        """Runs a program in the machine, in the project's folder, with its output shown.

        Args:
            words: Program and arguments; a single one is a line of bash.

        Returns:
            Its exit status, as a shell gives it.

        Raises:
            Interrupted: A signal ended it.
        """
        pip = os.path.join(self._cache, "pip")
        os.makedirs(pip, exist_ok=True)
        mounts = ["--bind", self.root, "/", "--dev", "/dev", "--proc", "/proc"]
        mounts += ["--ro-bind", "/sys", "/sys", "--bind", pip, "/root/.cache/pip"]
        for path in self._shown:
            mounts += ["--ro-bind", path, path]
        words = ["bash", "-c", *words] if len(words) == 1 else words
        program = ["sh", "-c", 'umask 022; exec "$@"', "sh", *words]
        return self._start([*mounts, "--chdir", PROJECT, *program], env=host.environment())

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
                shutil.rmtree(STAGED, ignore_errors=True)
                os.makedirs(CACHE, exist_ok=True)
                self._tool(["cp", "-r", "--no-dereference", "--preserve=timestamps", left, STAGED])
                if os.path.lexists(there):
                    shutil.rmtree(there)
                os.makedirs(os.path.dirname(there), exist_ok=True)
                os.rename(STAGED, there)

    def _bootstrap(self):
        """Makes the Debian, and keeps it as a tarball."""
        mirror, log = host.mirror(), os.path.join(self._cache, f"mmdebstrap-{self._suite}.log")
        say(f"bare: making Debian {self._suite} with mmdebstrap, once (details in {log})")
        part = os.path.join(self._folder, "base.tar")
        options = [f"--aptopt={line}" for line in host.apt_proxies()]
        options.append("--dpkgopt=force-unsafe-io")  # it need not outlive a crash
        command = ["mmdebstrap", "--mode=root", "--variant=minbase", *options]
        try:
            with open(log, "wb") as stream:
                self._tool(
                    [*command, self._suite, part, mirror],
                    env={**os.environ, "TMPDIR": self._folder},
                    stdin=subprocess.DEVNULL,
                    stdout=stream,
                    stderr=stream,
                )
        except CommandError:
            raise CommandError(
                f"mmdebstrap made no Debian {self._suite} from {mirror}",
                f"The end of {log}:",
                *(f"| {line}" for line in tail(log, TAIL)),
            ) from None
        os.replace(part, self._base)

    def _kept(self):
        """Lists (folder in the cache, folder of the machine, suffix) of what is downloaded once."""
        wheels = f"{self.root}{PROJECT}/.cache/wheels"
        return (
            (f"{self._cache}/apt/{self._suite}", self.root + ARCHIVES, ".deb"),
            (f"{self._cache}/wheels", wheels, ".whl"),
        )

    def _keep(self):
        """Keeps the packages that were downloaded and the wheels that were compiled."""
        for kept, there, suffix in self._kept():
            _link(there, kept, suffix)

    def _tool(self, argv, **popen):
        """Runs a program of this machine that has to succeed."""
        status = self._start(["--dev-bind", "/", "/", "--proc", "/proc", *argv], **popen)
        if status != 0:
            raise CommandError(f"{' '.join(argv)} failed (exit status {status})")

    def _start(self, argv, env=os.environ, **popen):
        """Runs a program in namespaces of its own, which end with it and with ./run."""
        path = f"{env.get('PATH', '')}:{SYSTEM_PATH}".lstrip(":")
        status = processes.run_child(
            [*ISOLATED, *argv],
            signals=self._signals,
            pass_fds=(self._lock,),
            env={**env, "PATH": path},
            **popen,
        )
        return processes.exit_status(status)


def isolation():
    """Returns whether root may have namespaces, mounts and chroot here."""
    probe = ["unshare", "--mount", "--pid", "--fork", "--mount-proc", "chroot", "/", "true"]
    environ = {**os.environ, "PATH": f"{os.environ.get('PATH', '')}:{SYSTEM_PATH}"}
    return subprocess.run(probe, env=environ, capture_output=True).returncode == 0


def _link(source, target, suffix):
    """Links the whole files of a folder that another one has not: no half wheels of a killed run;
    apt moves only whole packages."""
    for path in glob.glob(os.path.join(source, f"*{suffix}")):
        if suffix == ".deb" or zipfile.is_zipfile(path):
            os.makedirs(target, exist_ok=True)
            with contextlib.suppress(FileExistsError):
                os.link(path, os.path.join(target, os.path.basename(path)), follow_symlinks=False)


def _locked(folder):
    """Locks a machine; gives the file descriptor that holds it.

    Raises:
        BlockingIOError: A run does.
    """
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(opened)
        raise
    return opened


def _remove(folder):
    """Removes a machine, not across file systems, and where a Ctrl-C does not reach.

    Raises:
        CommandError: Something of it cannot be removed.
    """
    rm = ["rm", "-rf", "--one-file-system", "--", folder]
    end = time.monotonic() + REMOVAL_LIMIT
    while True:
        done = subprocess.run(rm, capture_output=True, text=True, start_new_session=True)
        if not os.path.lexists(folder):
            return
        if time.monotonic() > end:
            said = done.stderr.strip().partition("\n")[0]
            raise CommandError(f"the bare machine's folder {folder} cannot be removed: {said}")
        time.sleep(0.1)  # a killed process may still be ending
