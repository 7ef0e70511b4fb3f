"""Processes under test: a Graph with folders of its own, and how it shuts down."""

import operator
import pathlib
import shutil
import time
from dataclasses import dataclass

from launching import Graph
from usage import procfs, role_of

from soaking.limits import CompetingLoad

PERIOD = 0.03  # [s] between two samples


@dataclass
class Shutdown:
    """How processes ended.

    Attributes:
        seconds: Since the begin until none was left, or until it was not waited for any more.
        left: Command lines of what is left.
        lives: (role, seconds since the begin when it was last seen), the longest life last.
        slowdown: By the competing load, see CompetingLoad.
    """

    seconds: float
    left: list
    lives: list
    slowdown: float


class ProcessesUnderTest(Graph):
    """Processes on a ROS master of their own, with a folder for logs and temporary files.

    Args:
        folder: pathlib.Path for logs and temporary files, emptied first.
        log: Name of the file there for what the processes print.

    Attributes:
        temporary: Folder that they take for temporary files.
    """

    def __init__(self, folder, log, **variables):
        shutil.rmtree(folder, ignore_errors=True)
        self.folder, self.temporary = folder, folder / "tmp"
        self.temporary.mkdir(parents=True)
        super().__init__(
            open(folder / log, "w"),
            ROS_LOG_DIR=str(folder / "log"),
            TMPDIR=str(self.temporary),
            **variables,
        )
        for name in ("DISPLAY", "WAYLAND_DISPLAY"):
            self.environment.pop(name, None)

    def output(self):
        """What its processes have printed so far."""
        return pathlib.Path(self._log.name).read_text(errors="replace")

    def files(self):
        """Names in the folder of temporary files, without Qt's own folder for sockets."""
        names = (path.name for path in self.temporary.iterdir())
        return sorted(name for name in names if not name.startswith("runtime-"))

    def wait_ended(self, limit, spared=(), begin=None):
        """Waits until its processes have ended.

        Args:
            limit: Longest wait in wall time [s]; longer under competing load, see CompetingLoad.
            spared: Roles that are not waited for, see usage.role_of.
            begin: time.monotonic() from which on the time counts [s]; None: now.

        Returns:
            (Shutdown, names of files in the temporary folder).
        """
        begin = time.monotonic() if begin is None else begin
        load, lives = CompetingLoad(), {}
        while True:
            words = {pid: line for pid in self.pids() if (line := procfs.arguments(pid))}
            left = {pid: line for pid, line in words.items() if role_of(line) not in spared}
            seconds = time.monotonic() - begin
            load.sample(words)
            for pid, line in left.items():
                lives[pid] = (role_of(line), seconds)
            if not left or seconds >= limit * load.slowdown():
                lines = [" ".join(line)[:160] for line in left.values()]
                last = sorted(lives.values(), key=operator.itemgetter(1))
                return Shutdown(seconds, lines, last, load.slowdown()), self.files()
            time.sleep(PERIOD)

    def close(self):
        """Ends everything, by SIGKILL."""
        super().close()
        self._log.close()
