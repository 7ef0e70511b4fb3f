"""A log that cannot be written must not stop a node: a full disk, a closed terminal or pipe.

rospy's handler of the console lets the error out into whoever logs, and Python's of files prints a
traceback for each line. Here a handler that fails is said once, and the node goes on.
"""

import logging
import sys

from rosgraph.roslogging import RosStreamHandler

_said = set()  # handlers that have failed


def bear_failures():
    """Changes the handlers of this process; to be called once, when the node starts."""
    logging.Handler.handleError = _failed
    if RosStreamHandler.emit is not _emit:
        RosStreamHandler.emit_or_raise = RosStreamHandler.emit
        RosStreamHandler.emit = _emit


def _emit(handler, record):
    try:
        handler.emit_or_raise(record)
    except (OSError, ValueError):  # ValueError: the stream is closed
        handler.handleError(record)


def _failed(handler, record):
    """Says once that a handler fails, wherever that can still be read."""
    error = sys.exc_info()[1]
    if handler in _said:
        return
    _said.add(handler)
    name = getattr(handler, "baseFilename", "the console")
    text = f"the log cannot be written to {name}: {error}; it is left out from now on"
    try:
        sys.stderr.write(f"{text}\n")
    except (OSError, ValueError):
        logging.getLogger("rosout").warning(text)
