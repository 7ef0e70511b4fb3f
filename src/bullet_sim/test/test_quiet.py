"""What libraries print is kept away, what Python prints meanwhile is not."""

import subprocess
import sys

SCRIPT = """
import os, sys, threading
from bullet_sim.system.quiet import keep_python_audible, quiet
if {audible}:
    keep_python_audible()
os.write(1, b'before ')
with quiet():
    os.write(1, b'hidden')
    os.write(2, b'hidden')
    speaker = threading.Thread(target=lambda: print('said', end=' ', flush=True))
    speaker.start()
    speaker.join()
    print('told', file=sys.stderr, end='', flush=True)
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


def test_libraries_are_quiet():
    assert run(False) == (b"before after", b"")


def test_python_is_heard():
    assert run(True) == (b"before said after", b"told")
