"""grade.py of the lab: what a driver that was handed in reaches, and what is kept of it."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import mounted_root
import pytest

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "docs" / "tutorials" / "class" / "grade.py"
SPEC = importlib.util.spec_from_file_location("grade", FILE)
grade = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(grade)

CURIOUS = """import json, os, socket, sys
import numpy, rospy, cv2
def refused(call):
    try:
        call()
    except OSError as error:
        return error.strerror
seen = {name: os.path.exists(name) for name in sys.argv[1:]}
print(json.dumps({
    "seen": seen,
    "network": refused(lambda: socket.create_connection(("192.0.2.1", 80), 2)),
    "write": refused(lambda: open(os.environ["PADDOCK_ROOT"] + "/src/mine", "w")),
    "processes": sum(name.isdigit() for name in os.listdir("/proc")),
    "secret": os.environ.get("SECRET"),
    "here": sorted(os.listdir()),
}))
"""


# Takes other /proc away, as a machine without chroots has none, in mounts of its own.
OTHERS = """awk '$3 == "proc" && $2 != "/proc" {print $2}' /proc/mounts"""
ALONE = OTHERS + ' | xargs -r umount -l; exec "$@"'


def world():
    """Words before the command of a world."""
    alone = ["unshare", "--mount", "sh", "-c", ALONE, "sh"] if os.geteuid() == 0 else []
    return [*mounted_root.words("/"), *alone, *grade.WORLD]


def test_a_driver_sees_the_system_paddock_and_itself_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("SECRET", "of the teacher")
    driver, solution = tmp_path / "driver.py", tmp_path / "solution.py"
    driver.write_text(CURIOUS)
    solution.write_text("")
    hidden = [str(solution), str(ROOT / ".git"), "/etc/shadow", "/root", os.path.expanduser("~")]
    words = [*world(), *grade.enclosed(driver), sys.executable, "/tmp/driver.py", *hidden]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert not any(found["seen"].values()), found["seen"]
    assert found["network"] == "Network is unreachable"
    assert found["write"] == "Read-only file system"
    assert found["processes"] <= 2 and found["secret"] is None and found["here"] == ["driver.py"]


@pytest.mark.parametrize(
    "text, said",
    [("x = bytearray(300 * 10**6)", "MemoryError"), ("print('x' * 10**7)", "File too large"),
     ("open('x', 'wb').write(bytes(10**8))", "File too large")],
)  # fmt: skip
def test_its_memory_and_files_have_limits(tmp_path, text, said):
    driver, log = tmp_path / "driver.py", tmp_path / "log.txt"
    driver.write_text(f"import signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n{text}\n")
    limits = grade.limits({"memory": 200, "wall_time_limit": 60})
    words = [*world(), *grade.enclosed(driver), *limits, sys.executable, "/tmp/driver.py"]
    with log.open("wb") as stream:
        done = subprocess.run(words, stdout=stream, stderr=subprocess.PIPE, text=True, timeout=120)
    assert done.returncode != 0 and said in done.stderr
    assert log.stat().st_size <= grade.PRINTED


def test_without_an_enclosure_nothing_runs_unless_it_is_trusted(tmp_path):
    """A PATH without bubblewrap, and one whose kernel allows no namespaces."""
    (tmp_path / "driver.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    refusing = tmp_path / "bin"
    refusing.mkdir()
    task = str(FILE.with_name("task.yaml"))
    refusal = "echo no namespaces >&2; exit 1"
    for text, why in ((None, "apt-get install bubblewrap"), (refusal, "no namespaces")):
        if text:
            (refusing / "bwrap").write_text(f"#!/bin/sh\n{text}\n")
            (refusing / "bwrap").chmod(0o755)
        done = subprocess.run(
            [sys.executable, str(FILE), task, str(tmp_path), str(tmp_path / "marks.csv")],
            env={**os.environ, "PATH": str(refusing)}, capture_output=True, text=True, timeout=120,
        )  # fmt: skip
        assert done.returncode == 1 and why in done.stderr and "--trust" in done.stderr
        assert not (tmp_path / "ran").exists() and not (tmp_path / "marks.csv").exists()
