"""silenced(): libraries print nothing, Python's own output stays."""

import subprocess
import sys

SCRIPT = """
import os, sys, threading
from bullet_sim.files import keep_python_output, silenced
if {audible}:
    keep_python_output()
os.write(1, b'before ')
with silenced():
    os.write(1, b'hidden')
    os.write(2, b'hidden')
    printer = threading.Thread(target=lambda: print('stdout', end=' ', flush=True))
    printer.start()
    printer.join()
    print('stderr', file=sys.stderr, end='', flush=True)
os.write(1, b'after')
"""


def run(audible):
    """Output and errors of the script."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(audible=audible)],
        timeout=180,
        capture_output=True,
        check=True,
    )
    return done.stdout, done.stderr


def test_libraries_are_silenced():
    assert run(False) == (b"before after", b"")


def test_python_output_is_kept():
    assert run(True) == (b"before stdout after", b"stderr")


OVERLAPPING = """
import os, threading
from bullet_sim.files import silenced
inside, leave = threading.Event(), threading.Event()

def first():
    with silenced():
        inside.set()
        leave.wait()

thread = threading.Thread(target=first)
thread.start()
inside.wait()
with silenced():
    leave.set()
    thread.join()
    os.write(1, b'hidden')
os.write(1, b'after')
"""


def test_output_comes_back_after_two_threads_that_overlap():
    done = subprocess.run(
        [sys.executable, "-c", OVERLAPPING], timeout=180, capture_output=True, check=True
    )
    assert done.stdout == b"after"
