"""What a test starts: processes with a mark, an environment, a log and temporary files."""

import os
import pathlib
import shutil
import subprocess
import uuid

from paddock_common.testing import free_port
from usage import roles_of

from soaking.marked import MARK, kill_all, marked, wait_none


class Subject:
    """Processes on a ROS master of their own, known by a mark in their environment.

    Args:
        folder: pathlib.Path for logs and temporary files, made anew.
        log: Name of the file there for what the processes print.
        **variables: More of their environment.

    Attributes:
        folder: pathlib.Path.
        mark: Of all processes.
        temporary: Folder that they take for temporary files.
        port: Of the ROS master.
        environment: dict of variables, without the mark.
    """

    def __init__(self, folder, log, **variables):
        shutil.rmtree(folder, ignore_errors=True)
        self.folder, self.mark, self.port = folder, uuid.uuid4().hex, free_port()
        self.temporary = folder / "tmp"
        self.temporary.mkdir(parents=True)
        self.environment = dict(
            os.environ,
            ROS_IP="127.0.0.1",
            ROS_MASTER_URI=f"http://127.0.0.1:{self.port}",
            ROS_LOG_DIR=str(folder / "log"),
            TMPDIR=str(self.temporary),
            **variables,
        )
        for name in ("ROS_HOSTNAME", "DISPLAY", "WAYLAND_DISPLAY"):
            self.environment.pop(name, None)
        self._log, self._started = open(folder / log, "w"), []

    def popen(self, *command, environment=None, **variables):
        """Starts a process with the mark.

        Args:
            *command: Words.
            environment: Variables; None: those of the subject.
            **variables: More of them.

        Returns:
            subprocess.Popen.
        """
        process = subprocess.Popen(
            command,
            env={**(environment or self.environment), MARK: self.mark, **variables},
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._started.append(process)
        return process

    def roles(self):
        """Role -> pids of the subject's processes, see usage.role_of."""
        return roles_of(marked(self.mark))

    def said(self):
        """What its processes have printed so far."""
        return pathlib.Path(self._log.name).read_text(errors="replace")

    def files(self):
        """Names in the folder of temporary files, without Qt's own folder for sockets."""
        names = (path.name for path in self.temporary.iterdir())
        return sorted(name for name in names if not name.startswith("runtime-"))

    def ended(self, begin, limit, spared=()):
        """Waits until its processes have ended.

        Args:
            begin: time.monotonic() from which on the time counts [s].
            limit: Longest wait since then [s].
            spared: Roles that are not waited for.

        Returns:
            (Ending, names of files in the temporary folder).
        """
        return wait_none(self.mark, limit, spared, begin), self.files()

    def close(self):
        """Ends everything, by SIGKILL."""
        kill_all(self.mark)
        for process in self._started:
            process.wait()
        self._log.close()
