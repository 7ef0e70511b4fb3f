"""Shared by tests of several packages and by the bench: ports, processes and their end."""

import contextlib
import itertools
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, HTTPServer

FIRST, LAST = 20000, 32000  # below those that the kernel gives to whoever asks for any port
POLL_PERIOD = 0.005  # [s]
_servers = itertools.count()  # X servers that this process has started


def free_port():
    """Returns an unused TCP port outside the range that the kernel assigns."""
    for port in random.sample(range(FIRST, LAST), 100):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise OSError(f"no free port found between {FIRST} and {LAST}")


class _Page(BaseHTTPRequestHandler):
    def do_POST(self):
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(200)
        self.end_headers()
        self.wfile.write(b"<html><p>hello<br></html>")

    def log_message(self, *_):
        pass


@contextlib.contextmanager
def web_page():
    """Yields the address of a server that gives a web page to whoever calls it by XML-RPC."""
    with HTTPServer(("127.0.0.1", 0), _Page) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


def start_x_server(size):
    """Starts an Xvfb on a display that no other process here has.

    Servers that choose a number themselves (-displayfd alone) take each other's sockets away when
    they start in the same moment.

    Args:
        size: WIDTHxHEIGHT [px].

    Returns:
        Its subprocess.Popen, the display's name.
    """
    display = f":{1000 + (8 * os.getpid() + next(_servers)) % 50000}"
    screen = ("-screen", "0", f"{size}x24")
    reader, writer = os.pipe()
    process = subprocess.Popen(
        # Without -noreset it starts over when its last client leaves, and refuses the next meanwhile.
        ["Xvfb", display, "-displayfd", str(writer), *screen, "-nolisten", "tcp", "-noreset"],
        pass_fds=[writer],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(writer)
    with os.fdopen(reader) as stream:
        number = stream.readline().strip()
    assert number, "Xvfb did not start"
    return process, f":{number}"


def is_running(pid):
    """Returns whether a process runs; one that has ended but was not waited for does not."""
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_ended(pid, limit):
    """Waits until a process has ended.

    Args:
        pid: Process id.
        limit: Longest wait in wall time [s].

    Raises:
        AssertionError: It runs on.
    """
    deadline = time.monotonic() + limit
    while is_running(pid):
        assert time.monotonic() < deadline, f"process {pid} has not ended within {limit:g} s"
        time.sleep(POLL_PERIOD)


def pid_from_killed(code):
    """Runs Python code that prints a process id, kills it, and returns that id.

    Args:
        code: Python source; it has to go on running after it has printed.
    """
    parent = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)),
    )
    with parent:
        pid = int(parent.stdout.readline())
        parent.kill()
    return pid


def stop_session(process, limit):
    """Ends a process and all of its session as Ctrl-C does; kills what does not end.

    Args:
        process: subprocess.Popen with start_new_session=True.
        limit: Wall time from SIGINT to SIGKILL [s].

    Raises:
        AssertionError: It had to be killed.
    """
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        name = os.path.basename(process.args[0])
        raise AssertionError(f"{name} did not end within {limit:g} s") from None
