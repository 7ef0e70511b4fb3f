"""Starting and ending the render process, and why it ended."""

import os
import pathlib
import subprocess
import sys
import tempfile
from multiprocessing.connection import Connection

from bullet_sim.errors import RenderError
from bullet_sim.render.shared_memory import DoubleBuffer, SharedMemory
from bullet_sim.system.sockets import blocking_pair

START_TIMEOUT = 60.0  # [s] of wall time; a cold Mesa compiles shaders
_ROOT = str(pathlib.Path(__file__).resolve().parents[2])


class Worker:
    """One render process and the socket to it.

    Args:
        kind: 'egl' or 'tiny'.
        environment: variables added to the process's environment.
        timeout: for its start, [s] of wall time.

    Attributes:
        connection: multiprocessing Connection; see worker.py for the messages.
        memory: SharedMemory that it draws to.
        buffers: DoubleBuffer in it.
        process: subprocess.Popen.

    Raises:
        RenderError: it did not start; the message has the end of its output.
    """

    def __init__(self, kind, environment, timeout=START_TIMEOUT):
        paths = [_ROOT, os.environ.get("PYTHONPATH", "")]
        variables = dict(os.environ, **environment)
        variables["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
        self._log = tempfile.TemporaryFile()
        parent_end, child_end = blocking_pair()
        self.kind = kind
        self.memory = SharedMemory()
        self.buffers = DoubleBuffer(self.memory)
        try:
            self.process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "bullet_sim.render.worker",
                    str(child_end.fileno()),
                    str(self.memory.fd),
                    kind,
                ],
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                env=variables,
                pass_fds=[child_end.fileno(), self.memory.fd],
            )
        finally:
            child_end.close()
        self.connection = Connection(parent_end.detach())
        try:
            if not self.connection.poll(timeout):
                raise RenderError(f"the {kind} renderer is not ready after {timeout:g} s")
            self.connection.recv()
        except (EOFError, ConnectionError):
            reason = self.exit_reason()
            self.close()
            raise RenderError(reason) from None
        except RenderError:
            self.close(kill=True)
            raise

    def exit_reason(self):
        """The reason why the process ended, in one line."""
        try:
            code = self.process.wait(2.0)
        except subprocess.TimeoutExpired:
            return f"the {self.kind} renderer (pid {self.process.pid}) closed its connection"
        size = self._log.seek(0, os.SEEK_END)
        self._log.seek(max(0, size - 4000))
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        end = f"signal {-code}" if code < 0 else f"exit code {code}"
        text = f"the {self.kind} renderer (pid {self.process.pid}) ended with {end}"
        return f"{text}: {lines[-1].strip()}" if lines else text

    def close(self, kill=False):
        """End the process by closing its connection; kill: by SIGKILL."""
        self.connection.close()
        if kill:
            self.process.kill()
        try:
            self.process.wait(3.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._log.close()
        self.memory.close()
