"""./run desk: its arguments, what it hands on, its password, its port, its way into X."""

import socket
import stat
import struct

import pytest

from commands import locks, parsing
from commands.errors import CommandError
from commands.subcommands import desk

DEFAULT = ("1600x900", None, False)


@pytest.mark.parametrize("line, own, shown", [
    ("--size 1280x720 --share --port 9000 exec lap --port 7", ("1280x720", 9000, True),
     "exec lap --port 7"),  # those of the desk stand before the command
    ("--size=800x600", ("800x600", None, False), ""),
    ("track:=hard", DEFAULT, "track:=hard"),
    ("truck", DEFAULT, "truck rviz:=true"),  # commands without a window show rviz
    ("truck gui:=true", DEFAULT, "truck gui:=true"),
    ("truck --back line", DEFAULT, "truck --back line"),
    ("lap rviz:=false", DEFAULT, "lap rviz:=false platform:=xcb"),
    ("lap --driver line", DEFAULT, "lap --driver line rviz:=true platform:=xcb"),
    ("exec roslaunch a b.launch", DEFAULT, "exec roslaunch a b.launch"),
])  # fmt: skip
def test_options_of_the_desk_and_what_it_shows(line, own, shown):
    options, command = parsing.split("desk", desk, line.split(), "shows")
    assert (options.size, options.port, options.share) == own
    assert desk.shown(command) == shown.split()


def test_the_first_free_port_is_taken_and_a_given_one_has_to_be_free():
    with locks.listen(None, desk.PORTS) as first, locks.listen(None, desk.PORTS) as second:
        address, taken = first.getsockname()
        assert address == "127.0.0.1" and taken in desk.PORTS
        assert second.getsockname()[1] > taken
        with pytest.raises(CommandError, match=f"cannot listen on port {taken}: Address already"):
            locks.listen(taken, desk.PORTS)
    with locks.listen(None, desk.PORTS, desk.EVERYWHERE) as server:
        assert server.getsockname()[0] == "0.0.0.0"


def test_a_password_is_kept_as_vnc_wants_it_and_for_this_user_alone(tmp_path):
    options = desk._security(str(tmp_path), "parking")
    assert options == ["-SecurityTypes", "VncAuth", "-PasswordFile", str(tmp_path / "password")]
    kept = tmp_path / "password"
    assert len(kept.read_bytes()) == 8 and b"parking" not in kept.read_bytes()
    assert stat.S_IMODE(kept.stat().st_mode) == 0o600
    assert desk._security(str(tmp_path), None) == ["-SecurityTypes", "None"]


def test_an_x_server_takes_the_cookie_and_no_other(tmp_path):
    running = desk.Screen(str(tmp_path), "640x480")
    try:
        cookie = (tmp_path / "authority").read_bytes()[-16:]
        assert answer(running.display, cookie) == 1
        assert answer(running.display, bytes(16)) == 0
    finally:
        running.process.terminate()
        running.process.wait(60.0)


def answer(display, cookie):
    """Opens a connection to an X server; gives its first byte: 1 is success, 0 is refusal."""
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(f"/tmp/.X11-unix/X{display[1:]}")
        head = struct.pack("<cxHHHHxx", b"l", 11, 0, len(desk.COOKIE), len(cookie))
        client.sendall(head + desk.COOKIE.ljust(20, b"\0") + cookie)
        return client.recv(1)[0]
