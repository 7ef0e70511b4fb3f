"""Nodes survive a full disk and a closed terminal."""

import logging
import os
import subprocess
import sys
from pathlib import Path

from paddock_common import nodes

CODE = """
import logging, logging.handlers, sys
from paddock_common import nodes
from rosgraph.roslogging import RosStreamHandler
nodes.tolerate_log_errors()
nodes.tolerate_log_errors()
log = logging.getLogger("rosout")
log.setLevel(logging.INFO)
log.addHandler(RosStreamHandler())
log.addHandler(logging.handlers.RotatingFileHandler(sys.argv[1]))
for number in range(20):
    log.info("line %d", number)
    log.warning("warning %d", number)
open(sys.argv[2], "w").write("continued")
"""


def run(tmp_path, log, **streams):
    """Runs a node that logs; returns its CompletedProcess after it has continued."""
    done = subprocess.run(
        [sys.executable, "-u", "-c", CODE, str(log), str(tmp_path / "end")],
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)),
        text=True,
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams},
    )
    assert (tmp_path / "end").read_text() == "continued"
    assert done.returncode == 0
    return done


def test_a_full_disk_is_reported_once(tmp_path):
    done = run(tmp_path, "/dev/full")
    assert done.stderr.count("No space left on device") == 1
    assert "the log cannot be written to /dev/full" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout.count("line") == 20  # the console continues


def test_a_full_disk_under_the_console_does_not_affect_the_file(tmp_path):
    with open("/dev/full", "w") as full:
        run(tmp_path, tmp_path / "log", stdout=full, stderr=full)
    text = (tmp_path / "log").read_text()
    assert text.count("line ") == 20 and text.count("warning ") == 20
    assert text.count("the log cannot be written to the console") == 1


def test_a_closed_terminal_does_not_affect_the_file(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    try:
        run(tmp_path, tmp_path / "log", stdout=writer, stderr=writer)
    finally:
        os.close(writer)
    assert Path(tmp_path / "log").read_text().count("line ") == 20


def test_a_message_of_megabytes_is_logged_without_its_middle():
    """As of a model's name; each of its messages had all of it."""
    seen, handler = [], logging.Handler()
    handler.emit = lambda record: seen.append(record.getMessage())
    logger = logging.getLogger("rosout")
    logger.addHandler(handler)
    logger.addFilter(nodes._shorten)
    try:
        logger.warning("model '%s' is there", "x" * 50_000_000)
    finally:
        logger.removeHandler(handler)
        logger.removeFilter(nodes._shorten)
    assert len(seen[0]) < 2 * nodes.LONGEST_MESSAGE
    assert seen[0].startswith("model 'xx") and seen[0].endswith("xx' is there")
