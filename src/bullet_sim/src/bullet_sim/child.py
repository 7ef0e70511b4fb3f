"""Child processes: a socket to one, what it prints, and how it ended."""

import os
import socket
import subprocess
import tempfile
from collections.abc import Mapping, Sequence

TAIL = 4000  # [bytes] of what it prints that are read for the reason of its end


def blocking_pair() -> tuple[socket.socket, socket.socket]:
    """A connected pair of blocking Unix stream sockets.

    With the default time-out that rospy sets they would be non-blocking file descriptors.
    """
    pair = socket.socketpair()
    for end in pair:
        end.setblocking(True)
    return pair


class Child:
    """A process that is started with one end of a socket pair.

    Args:
        name: for messages: the viewer.
        command: words; the number of its end's file descriptor is appended.
        arguments: words after that.
        descriptors: further file descriptors that it inherits.
        environment: of the process; None: as here.
        logged: whether what it prints goes to a file; else it goes where it does here.

    Attributes:
        name: with the process id.
        process: subprocess.Popen.
        socket: the other end, blocking.

    Raises:
        OSError: it does not start.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        arguments: Sequence[str] = (),
        descriptors: Sequence[int] = (),
        environment: Mapping[str, str] | None = None,
        logged: bool = True,
    ) -> None:
        self.socket, its_end = blocking_pair()
        self._log = tempfile.TemporaryFile() if logged else None
        try:
            self.process = subprocess.Popen(
                [*command, str(its_end.fileno()), *arguments],
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                env=environment,
                pass_fds=[its_end.fileno(), *descriptors],
            )
        except OSError:
            self.close()
            raise
        finally:
            its_end.close()
        self.name = f"{name} (pid {self.process.pid})"

    def shut_down(self) -> None:
        """End the stream: the process reads its end and is expected to exit; any thread."""
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass

    def wait(self, timeout: float) -> None:
        """Wait for its end; kill it after a time-out [s]."""
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def ending(self, ignored: str | tuple[str, ...] = ()) -> str:
        """How it ended, in one line: exit code or signal, and the last line in its log.

        Args:
            ignored: what lines that do not count begin with, a text or several.
        """
        code = self.process.returncode
        text = f"{self.name} ended with " + (f"signal {-code}" if code < 0 else f"exit code {code}")
        if self._log is None:
            return text
        size = self._log.seek(0, os.SEEK_END)
        self._log.seek(max(0, size - TAIL))
        lines = self._log.read().decode(errors="replace").splitlines()
        lines = [line.strip() for line in lines if line.strip() and not line.startswith(ignored)]
        return f"{text}: {lines[-1]}" if lines else text

    def close(self) -> None:
        """Close socket and file."""
        self.socket.close()
        if self._log is not None:
            self._log.close()
