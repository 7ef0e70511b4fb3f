"""Starting and ending the render process, and why it ended."""

import os
import pathlib
import pickle
import socket
import struct
import subprocess
import sys
import tempfile
from multiprocessing.connection import Connection

from bullet_sim.errors import RenderError
from bullet_sim.render.request import DEFAULT
from bullet_sim.render.shared_memory import BufferRing, SharedMemory
from bullet_sim.system.sockets import blocking_pair

HANG_TIMEOUT = 2.5  # [s] of wall time without an answer or any use of a processor
HANG_CHECK = 0.25  # [s] between two looks; a debugger's stop of everything counts as one
START_TIMEOUT = 60.0  # [s] of wall time; a cold Mesa compiles shaders
AHEAD = 2  # orders that it may have: it begins the next one without waiting for its parent
_HEADER = struct.Struct("!i")
_ROOT = str(pathlib.Path(__file__).resolve().parents[2])


class Worker:
    """One render process and the socket to it.

    Args:
        kind: 'gl' or 'tiny'.
        environment: variables added to the process's environment.
        quality: Quality.
        timeout: for its start, [s] of wall time.

    Attributes:
        details: what draws, in a few words.
        connection: multiprocessing Connection to send to; see worker.py for the messages.
        memory: SharedMemory that it draws to.
        buffers: BufferRing in it: one for the pictures that are handed on, the others for orders
            that were sent.
        process: subprocess.Popen.

    Raises:
        RenderError: it did not start; the message has the end of its output.
    """

    def __init__(self, kind, environment, quality=DEFAULT, timeout=START_TIMEOUT):
        paths = [_ROOT, os.environ.get("PYTHONPATH", "")]
        variables = dict(os.environ, **environment)
        variables["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
        self._log = tempfile.TemporaryFile()
        parent_end, child_end = blocking_pair()
        self.kind = kind
        self.memory = SharedMemory()
        self.buffers = BufferRing(self.memory, 1 + AHEAD)
        try:
            self.process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "bullet_sim.render.worker",
                    str(child_end.fileno()),
                    str(self.memory.fd),
                    kind,
                    quality.shadows,
                    quality.antialias,
                ],
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                env=variables,
                pass_fds=[child_end.fileno(), self.memory.fd],
            )
        finally:
            child_end.close()
        self._answers, self._unread = parent_end, b""
        self.connection = Connection(os.dup(parent_end.fileno()))
        self._hung = ""
        try:
            if not self.connection.poll(timeout):
                raise RenderError(f"the {kind} renderer is not ready after {timeout:g} s")
            _, self.details = self.connection.recv()
            parent_end.setsockopt(
                socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", 0, int(1e6 * HANG_CHECK))
            )
        except (EOFError, ConnectionError):
            reason = self.exit_reason()
            self.close()
            raise RenderError(reason) from None
        except RenderError:
            self.close(kill=True)
            raise

    def receive(self):
        """The next message from it.

        Raises:
            EOFError, OSError: it ended, or was killed here because it hung: no answer for
                HANG_TIMEOUT and no processor time used meanwhile, as when it is stopped.
        """
        used, idle = None, 0
        while not self._has_answer():
            try:
                # One system call: each gives up the GIL, for which the physics competes.
                data = self._answers.recv(65536)
            except BlockingIOError:  # nothing for HANG_CHECK
                before, (state, used) = used, self._stat()
                waits = before is None or used > before or state == "R"  # R: for a processor
                idle = 0 if waits else idle + 1
                if idle * HANG_CHECK >= HANG_TIMEOUT:
                    self._hung = (
                        f"the {self.kind} renderer (pid {self.process.pid}) did nothing for "
                        f"{HANG_TIMEOUT:g} s and was ended"
                    )
                    self.process.kill()
                    raise EOFError(self._hung) from None
                continue
            if not data:
                raise EOFError("the renderer closed its connection")
            self._unread += data
        end = self._answer_end()
        answer, self._unread = self._unread[_HEADER.size : end], self._unread[end:]
        return pickle.loads(answer)

    def _answer_end(self):
        """Where the first answer among the received bytes ends, as Connection.send frames it."""
        return _HEADER.size + _HEADER.unpack_from(self._unread)[0]

    def _has_answer(self):
        return len(self._unread) >= _HEADER.size and len(self._unread) >= self._answer_end()

    def _stat(self):
        """State and processor time [ticks] of the process."""
        try:
            with open(f"/proc/{self.process.pid}/stat", encoding="ascii", errors="replace") as file:
                words = file.read().rpartition(")")[2].split()
        except OSError:
            return "", 0
        return words[0], int(words[11]) + int(words[12])

    def exit_reason(self):
        """The reason why the process ended, in one line."""
        if self._hung:
            return self._hung
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
        self._answers.close()
        if kill:
            self.process.kill()
        try:
            self.process.wait(3.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._log.close()
        self.memory.close()
