"""Child processes: their socket, their output, their priority, and how they exited."""

from __future__ import annotations

import os
import socket
import subprocess
import tempfile
from collections.abc import Mapping, Sequence

TAIL = 4000  # [bytes] of its output that are searched for the reason of its exit
_OWN = os.getpriority(os.PRIO_PROCESS, 0)  # this process' niceness, before a thread has another


def blocking_pair() -> tuple[socket.socket, socket.socket]:
    """A connected pair of blocking Unix stream sockets.

    With the default timeout that rospy sets they would be non-blocking file descriptors.
    """
    pair = socket.socketpair()
    for end in pair:
        end.setblocking(True)
    return pair


def _set_niceness(pid: int, niceness: int) -> None:
    """Set the niceness of a process and its session; one that has exited has none."""
    try:
        os.setpriority(os.PRIO_PROCESS, pid, niceness)
        with open(f"/proc/{pid}/autogroup", "w", encoding="ascii") as stream:
            stream.write(str(niceness))
    except OSError:
        pass  # also where the kernel has no such groups


class Child:
    """A process that is started with one end of a socket pair.

    Args:
        name: for messages: the render worker.
        command: program and arguments; the descriptor number of its socket is appended.
        arguments: further arguments, after that number.
        descriptors: further file descriptors that it inherits.
        environment: of the process; None: inherited.
        logged: whether its output goes to a temporary file; else to this process' output.
        niceness: how much lower its priority is than this process' was, 0 to 19; it gets a session
            of its own, since Linux applies the niceness of sessions first (autogroup).

    Attributes:
        name: with the process ID.
        socket: this process' end of the pair, blocking.

    Raises:
        OSError: it cannot be started.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        arguments: Sequence[str] = (),
        descriptors: Sequence[int] = (),
        environment: Mapping[str, str] | None = None,
        logged: bool = True,
        niceness: int | None = None,
    ) -> None:
        self.socket, child_socket = blocking_pair()
        self._log = tempfile.TemporaryFile() if logged else None
        try:
            self.process = subprocess.Popen(
                [*command, str(child_socket.fileno()), *arguments],
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                env=environment,
                pass_fds=[child_socket.fileno(), *descriptors],
                start_new_session=niceness is not None,
            )
        except OSError:
            self.close()
            raise
        finally:
            child_socket.close()
        self.name = f"{name} (pid {self.process.pid})"
        if niceness is not None:
            _set_niceness(self.process.pid, min(19, _OWN + niceness))

    def shut_down(self) -> None:
        """Close the stream: the process reads end-of-file and is expected to exit; any thread."""
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass

    def wait(self, timeout: float) -> None:
        """Wait until it exits; kill it after a timeout [s]."""
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def ending(self) -> str:
        """How it exited, in one line: exit code or signal, and the last line of its log."""
        code = self.process.returncode
        text = f"{self.name} ended with " + (f"signal {-code}" if code < 0 else f"exit code {code}")
        if self._log is None:
            return text
        size = self._log.seek(0, os.SEEK_END)
        self._log.seek(max(0, size - TAIL))
        lines = self._log.read().decode(errors="replace").splitlines()
        lines = [line.strip() for line in lines if line.strip()]
        return f"{text}: {lines[-1]}" if lines else text

    def close(self) -> None:
        """Close socket and file."""
        self.socket.close()
        if self._log is not None:
            self._log.close()
