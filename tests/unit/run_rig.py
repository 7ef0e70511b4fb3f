"""For the tests of ./run: starting it, a small clone of its own, and a package index for that."""

import base64
import hashlib
import http.server
import io
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import threading
import zipfile
from dataclasses import dataclass

from users_rig import CMAKE, MANIFEST

ROOT = pathlib.Path(__file__).resolve().parents[2]
PATIENCE = 300.0  # longest wait for anything [s] of wall time
NOISE = ("_", "PWD", "OLDPWD", "SHLVL")  # bash's own variables

sys.path.append(str(ROOT))  # for the package commands


def ran(*words, **options):
    """Runs a program to its end.

    Returns:
        subprocess.CompletedProcess with texts.
    """
    options = {"capture_output": True, "text": True, "timeout": PATIENCE, **options}
    return subprocess.run([*map(str, words)], check=False, **options)


def run(*arguments, root=ROOT, **options):
    """Runs ./run to its end; returns what ran() does."""
    return ran(root / "run", *arguments, **options)


class Like(str):
    """A text that every text equals that has its parts; any text may be where it has "..."."""

    __hash__ = None

    def __eq__(self, other):
        parts = map(re.escape, self.split("..."))
        return bool(re.fullmatch(".*".join(parts), other, re.DOTALL))


def program(path, text):
    """Writes a program."""
    path.write_text(text)
    path.chmod(0o755)


def usual_signals():
    """For preexec_fn: signals as in a terminal, also under nohup and in a background job."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def start(*arguments, root=ROOT, **options):
    """Starts ./run with pipes, in a session of its own, as from a terminal (SIGINT not ignored).

    Returns:
        subprocess.Popen.
    """
    return subprocess.Popen(
        [str(root / "run"), *arguments],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=usual_signals,
        **{"stderr": subprocess.STDOUT, **options},
    )


def make_package(folder, name, *wanted, tag="depend"):
    """Writes a package that asks for others into a folder, which it makes; returns that.

    Args:
        name: Blanks around it are allowed.
        tag: Of what is wanted.
    """
    folder.mkdir(parents=True, exist_ok=True)
    asked = "".join(f"<{tag}>{each}</{tag}>" for each in wanted)
    text = MANIFEST.format(name).replace("</package>", f"{asked}</package>")
    (folder / "package.xml").write_text(text)
    return folder


def small_clone(folder):
    """Makes a clone that is set up in seconds: our ./run, one package that builds nothing.

    Args:
        folder: Where; must not exist.
    """
    folder.mkdir(parents=True)
    for name in ("commands", "config"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "run", folder / "run")
    (folder / "src" / "standins").mkdir(parents=True)
    shutil.copy(ROOT / "src" / "standins" / "give_way.py", folder / "src" / "standins")
    for name in ("requirements.txt", "requirements-opencv.txt"):
        (folder / "config" / name).write_text("paddock-probe==1.0\n")
    package = make_package(folder / "src" / "probe", "probe")
    (package / "nodes").mkdir()
    (package / "nodes" / "probe").write_text("#!/usr/bin/env python3\n")
    (package / "CMakeLists.txt").write_text(CMAKE.format("probe"))
    return folder


@dataclass(frozen=True)
class Interruption:
    """What an interrupted set-up left.

    Attributes:
        working: Command lines of its processes before.
        status: Exit status of ./run.
        said: What it printed.
        left: Command lines of its processes after.
        stamped: Whether .venv counts as complete.
    """

    root: pathlib.Path
    working: list
    status: int
    said: str
    left: list
    stamped: bool


def stamped(root):
    """Returns whether a clone's .venv counts as complete: "?" remembers no more than the ROS."""
    stamp = root / ".venv" / ".stamp"
    return stamp.exists() and not stamp.read_text().startswith("? ")


def processes_of(folder):
    """Lists command lines of the processes that have something to do with a folder."""
    from commands import procfs

    lines = (" ".join(procfs.arguments(pid)) for pid in procfs.pids() if pid != os.getpid())
    return [line for line in lines if str(folder) in line]


class PackageIndex:
    """A package index on this machine that has paddock-probe 1.0, and answers when it is told to.

    Attributes:
        asked: Event: somebody asked for the package.
        open: Event: requests are answered; until then they wait.
    """

    def __init__(self):
        self.asked, self.open = threading.Event(), threading.Event()
        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def close(self):
        """Stops it; requests that wait are answered."""
        self.open.set()
        self._server.shutdown()
        self._server.server_close()

    def environment(self):
        """Gives an environment in which pip uses this index, and what ./run checks is there."""
        environ = dict(os.environ)
        for name in ("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY"):
            environ.pop(name, None)
        environ.pop("PYTHONPYCACHEPREFIX", None)  # the runner's: each .venv's pip would stay there
        environ.update(
            PIP_INDEX_URL=f"http://127.0.0.1:{self._server.server_port}/simple",
            PIP_EXTRA_INDEX_URL="",
            PIP_CONFIG_FILE=os.devnull,
            PIP_NO_CACHE_DIR="1",
            PYTHONPATH=sysconfig.get_paths()["purelib"],
        )
        return environ

    def _handler(self):
        index = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):  # noqa: N802 - the library's name
                index.asked.set()
                index.open.wait(PATIENCE)
                name = "paddock_probe-1.0-py3-none-any.whl"
                page = f'<!DOCTYPE html><a href="/{name}">{name}</a>'.encode()
                wheel = self.path.endswith(".whl")
                self.send_response(200)
                kind = "application/zip" if wheel else "text/html"
                self.send_header("Content-Type", kind)
                self.end_headers()
                self.wfile.write(_wheel() if wheel else page)

            def log_message(self, *_):
                pass

        return Handler


def _wheel():
    """Gives the bytes of paddock-probe 1.0."""
    files = {
        "paddock_probe.py": b"",
        "paddock_probe-1.0.dist-info/METADATA": (
            b"Metadata-Version: 2.1\nName: paddock-probe\nVersion: 1.0\n"
        ),
        "paddock_probe-1.0.dist-info/WHEEL": (
            b"Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        ),
    }
    record = "".join(
        f"{name},sha256={_digest(content)},{len(content)}\n" for name, content in files.items()
    )
    files["paddock_probe-1.0.dist-info/RECORD"] = record.encode()
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as stream:
        for name, content in files.items():
            stream.writestr(name, content)
    return archive.getvalue()


def _digest(content):
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
