"""A desk from start to end: screen, windows, web server, and the command that runs there."""

import contextlib
import os
import secrets
import shutil
import socket
import subprocess
import tempfile

from commands import processes
from commands.desk import windows
from commands.desk.screen import Screen, spawn, tail
from commands.errors import CommandError, say
from commands.paths import PYTHON, ROOT

WEB = os.path.join(ROOT, "commands", "desk", "web.py")
PAGE = "/usr/share/novnc"
PORTS = range(6080, 6100)  # the first free one is taken
LOOPBACK, EVERYWHERE = "127.0.0.1", "0.0.0.0"
GRACE = 10.0  # from SIGTERM to SIGKILL for what the desk started [s]


def listen(port, share):
    """Opens the port on which browsers come in.

    Args:
        port: Its number; None for the first free one of PORTS.
        share: Whether other machines can reach it.

    Returns:
        Listening socket.

    Raises:
        CommandError: It is taken.
    """
    for number in PORTS if port is None else [port]:
        server = socket.socket()
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            server.bind((EVERYWHERE if share else LOOPBACK, number))
        except OSError as error:
            server.close()
            problem = error.strerror
            continue
        server.listen(100)
        return server
    asked = f"{PORTS[0]} to {PORTS[-1]}" if port is None else port
    raise CommandError(f"cannot listen on port {asked}: {problem}", "./run desk --port NUMBER ...")


class Desk:
    """A desk within a with statement.

    Attributes:
        url: What a browser opens.
        environ: The environment in which programs open their windows here.
    """

    def __init__(self, environ, size, port=None, password=None):
        """Notes what is wanted; nothing starts yet.

        Args:
            environ: Environment of the programs.
            size: Of the screen, such as "1600x900" [px].
            port: For browsers; None for a free one.
            password: Lets browsers of other machines in, who know it; None for this machine only.
        """
        self._size, self._port, self._password = size, port, password
        self.environ = {name: environ[name] for name in environ if name != "WAYLAND_DISPLAY"}
        self._parts = {}  # log's name -> process, in the order in which they started

    def __enter__(self):
        self._folder = tempfile.mkdtemp(prefix="paddock-desk-")  # for this user only
        try:
            with listen(self._port, self._password is not None) as server:
                screen = Screen(self._folder, self._size, self._password)
                self._parts["screen"] = screen.process
                self.environ.update(
                    DISPLAY=screen.display, XAUTHORITY=screen.authority, QT_QPA_PLATFORM="xcb"
                )
                self._parts["windows"] = windows.start(self._folder, self.environ)
                self._serve(server, screen.socket)
        except BaseException:
            self.__exit__()
            raise
        return self

    def _serve(self, server, vnc):
        token = secrets.token_urlsafe(16)
        host = socket.gethostname() if self._password is not None else LOOPBACK
        self.url = f"http://{host}:{server.getsockname()[1]}/{token}/"
        number = server.fileno()
        with open(os.path.join(self._folder, "web.log"), "wb") as log:
            self._parts["web"] = spawn(
                [PYTHON, "-I", WEB, str(number), vnc, PAGE],
                env={**os.environ, "DESK_TOKEN": token},
                pass_fds=[number],
                stdout=log,
                stderr=log,
            )

    def __exit__(self, *_):
        parts = reversed(self._parts.values())
        for process in parts:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(GRACE)
            process.kill()
            process.wait()
        shutil.rmtree(self._folder, ignore_errors=True)

    def run(self, command):
        """Runs a command on the desk to its end.

        Args:
            command: Program and arguments.

        Returns:
            Its exit status.

        Raises:
            Interrupted: A signal ended it.
        """
        return processes.run_child(
            command, group=False, tick=self._look, env=self.environ, stdin=subprocess.DEVNULL
        )

    def _look(self, _seconds):
        """Says once which part of the desk has ended before the command."""
        for name, process in list(self._parts.items()):
            if process.poll() is not None:
                del self._parts[name]
                log = tail(os.path.join(self._folder, f"{name}.log"))
                say("\n".join([f"the desk has lost its {name}:", *log]))
