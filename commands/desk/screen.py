"""The X server of the desk: Xtigervnc, which keeps the screen in memory and speaks VNC."""

import os
import secrets
import struct
import subprocess

from commands.errors import CommandError

COOKIE = b"MIT-MAGIC-COOKIE-1"
WILD = 0xFFFF  # FamilyWild of X authority files: any host, any display
PASSWORD_LENGTHS = range(6, 9)  # VNC takes no more than 8 characters


class Screen:
    """A running X server.

    Attributes:
        display: Its name, such as ":1".
        authority: File with the cookie that its programs need.
        socket: Path of the Unix socket on which it speaks VNC.
        process: subprocess.Popen.
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
            raise CommandError("the X server of the desk did not start", *tail(log))
        self.display = f":{number}"


def spawn(command, **popen):
    """Starts a helper of the desk; it ends with ./run, whatever becomes of that.

    A session of its own keeps a terminal's Ctrl-C for the command that runs on the desk.

    Returns:
        subprocess.Popen.
    """
    command = ["setpriv", "--pdeathsig", "TERM", *command]
    return subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True, **popen)


def tail(log, lines=5):
    """Gives the last lines of a log, as advice for an error."""
    with open(log, encoding="utf-8", errors="replace") as stream:
        return [line for line in stream.read().splitlines() if line][-lines:]


def authority_entry(cookie):
    """Gives an X authority file with one cookie (Xau library: big-endian counts before texts)."""
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
