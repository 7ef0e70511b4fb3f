"""Shows the window and rviz in a browser; this machine needs no screen.

COMMAND is what otherwise stands behind ./run: nothing (the track, the car and the window), launch
arguments, truck, lap, world, demo, exec with any program. For example:
  ./run desk rviz:=true
  ./run desk truck
  ./run desk lap --driver line
  ./run desk exec roslaunch my_car drive.launch
truck, lap and world have no window of their own and get rviz:=true, unless rviz or gui is given.

Windows stand side by side on a screen in memory (TigerVNC, i3); noVNC brings it into the browser.
Open the address that is printed: it has a token that is new at each start. Several browsers see
and use the same screen. The desk ends with its command, or with Ctrl-C.

Only this machine gets in; from another one: ssh -L 6080:127.0.0.1:6080 HOST, then the same address.
--share lets other machines in directly, with the token and a password of 6 to 8 characters
(DESK_PASSWORD, or asked for); nothing is encrypted then, so only in a network that you trust.
"""

import contextlib
import os
import re
import secrets
import shutil
import socket
import struct
import subprocess
import sys
import tempfile

from commands import environment, locks, parsing, processes
from commands.errors import CommandError, UsageError, say
from commands.paths import PYTHON, ROOT, tail

USAGE = "[--size WxH] [--port N] [--share] [COMMAND ...]"
COMMAND = True  # options behind the command are its own
PASSES_ON = True
# What lets commands that start no window show something.
SHOWN = {"truck": ["rviz:=true"], "world": ["rviz:=true"], "lap": ["rviz:=true"]}
ALWAYS = {"lap": ["platform:=xcb"]}  # the window of the drivers that use one
COOKIE = b"MIT-MAGIC-COOKIE-1"
WILD = 0xFFFF  # FamilyWild of X authority files: any host, any display
# Not one key or button is bound: keys belong to the windows, and nothing here starts a program.
WINDOWS_CONFIG = """\
# i3 config file (v4)
font pango:DejaVu Sans 9
ipc-socket {folder}/windows
default_orientation horizontal
default_border normal
focus_follows_mouse no
focus_on_window_activation focus
"""
WEB = os.path.join(ROOT, "commands", "desk_web.py")
PAGE = "/usr/share/novnc"
LOOPBACK, EVERYWHERE = "127.0.0.1", "0.0.0.0"
PORTS = range(6080, 6280)  # the first free one is taken
TAIL = 5  # lines of a log, as advice for an error
GRACE = 10.0  # from SIGTERM to SIGKILL for what the desk started [s]


def _is_valid(password):
    """Returns whether VNC can use a password."""
    return 6 <= len(password) <= 8 and password.isascii() and password.isprintable()


PASSWORD = "DESK_PASSWORD", "desk", "VNC takes 6 to 8 of ASCII", _is_valid


def add_arguments(parser):
    """Declares the desk's own options."""
    parsing.add_options(
        parser,
        ("--size", "WxH", _size, "1600x900", "of the screen (1600x900)"),
        ("--port", "N", parsing.port, None, "for browsers (6080, or the next free one)"),
    )
    parser.add_argument("--share", action="store_true", help="let other machines in, by password")


def run(arguments):
    """Runs the command on a desk; its exit status is the desk's."""
    from commands.bootstrap import packages

    options, words = parsing.split("desk", sys.modules[__name__], arguments, "shows")
    command = [os.path.join(ROOT, "run"), *shown(words)]
    password = parsing.asked_password(*PASSWORD) if options.share else None
    environment.ready()
    packages.prepare(packages.DESK_SERVER_LIST, packages.DESK_LIST)
    with Desk(environment.callers(), options.size, options.port, password) as desk:
        say(f"the desk, in a browser: {desk.url}")
        return processes.exit_status(desk.run(command))


def shown(words):
    """Adds to a command's words what makes it show something, if it has no window by itself."""
    name = words[0] if words else ""
    given = {word.partition(":=")[0] for word in words if ":=" in word}
    more = SHOWN.get(name, []) if not given & {"rviz", "gui"} and "--back" not in words else []
    return [*words, *more, *ALWAYS.get(name, [])]


complete = parsing.other_commands("desk")


def _size(text):
    if not re.fullmatch(r"[1-9]\d{2,3}x[1-9]\d{2,3}", text):
        raise UsageError(f"size is {text!r}; it must be WIDTHxHEIGHT in pixels, such as 1600x900")
    return text


class Screen:
    """A running X server.

    Attributes:
        display: Its name, such as ":1".
        authority: File with the cookie that its programs need.
        socket: Path of the Unix socket on which it speaks VNC.
    """

    def __init__(self, folder, size, password=None):
        """Starts it and waits until it takes connections.

        Args:
            folder: Private folder for its files.
            size: Width and height as text, such as "1600x900" [px].
            password: Of VNC; None for none.

        Raises:
            CommandError: It did not start.
        """
        self.authority = os.path.join(folder, "authority")
        self.socket = os.path.join(folder, "vnc")
        log = os.path.join(folder, "screen.log")
        _write(self.authority, authority_entry(secrets.token_bytes(16)))
        reader, writer = os.pipe()
        command = [
            *("Xtigervnc", "-displayfd", str(writer), "-auth", self.authority),
            *("-nolisten", "tcp", "-noreset", "-geometry", size, "-depth", "24"),
            *("-desktop", "Paddock", "-AlwaysShared", "-rfbport", "-1"),
            *("-rfbunixpath", self.socket, *_security(folder, password)),
        ]
        with open(log, "wb") as stream:
            self.process = spawn(command, stdout=stream, stderr=stream, pass_fds=[writer])
        os.close(writer)
        with os.fdopen(reader) as stream:
            number = stream.readline().strip()  # empty when it has ended
        if not number:
            raise CommandError("the X server of the desk did not start", *tail(log, TAIL))
        self.display = f":{number}"


def spawn(command, **popen):
    """Starts a helper of the desk; it ends with ./run, whatever becomes of that.

    A session of its own keeps a terminal's Ctrl-C for the command that runs on the desk.

    Returns:
        subprocess.Popen.
    """
    command = ["setpriv", "--pdeathsig", "TERM", *command]
    return subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True, **popen)


def authority_entry(cookie):
    """Returns an X authority file with one cookie (Xau library: big-endian counts before texts)."""
    fields = (b"", b"", COOKIE, cookie)  # address and display are any
    texts = b"".join(struct.pack(">H", len(field)) + field for field in fields)
    return struct.pack(">H", WILD) + texts


def _security(folder, password):
    if password is None:
        return ["-SecurityTypes", "None"]
    path = os.path.join(folder, "password")
    done = subprocess.run(
        ["tigervncpasswd", "-f"], input=password.encode() + b"\n", capture_output=True, check=True
    )
    _write(path, done.stdout)
    return ["-SecurityTypes", "VncAuth", "-PasswordFile", path]


def _write(path, content):
    """Writes a file that nobody else can read."""
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as stream:
        stream.write(content)


def start_window_manager(folder, environ):
    """Starts it.

    Args:
        folder: Private folder for its files.
        environ: With the screen's DISPLAY and XAUTHORITY.

    Returns:
        subprocess.Popen.
    """
    config = os.path.join(folder, "windows.conf")
    with open(config, "w", encoding="utf-8") as stream:
        stream.write(WINDOWS_CONFIG.format(folder=folder))
    with open(os.path.join(folder, "windows.log"), "wb") as log:
        return spawn(["i3", "-c", config], env=environ, stdout=log, stderr=log)


class Desk:
    """A desk within a with statement.

    Attributes:
        url: What a browser opens.
        environ: The environment in which programs open their windows here.
    """

    def __init__(self, environ, size, port=None, password=None):
        """Notes what is wanted; nothing starts yet.

        Args:
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
            address = LOOPBACK if self._password is None else EVERYWHERE
            with locks.listen(self._port, PORTS, address) as server:
                screen = Screen(self._folder, self._size, self._password)
                self._parts["screen"] = screen.process
                self.environ.update(
                    DISPLAY=screen.display, XAUTHORITY=screen.authority, QT_QPA_PLATFORM="xcb"
                )
                self._parts["windows"] = start_window_manager(self._folder, self.environ)
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
                log = tail(os.path.join(self._folder, f"{name}.log"), TAIL)
                say("\n".join([f"the desk has lost its {name}:", *log]))
