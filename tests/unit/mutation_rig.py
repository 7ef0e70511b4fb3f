"""Loads many broken files in a child process of bounded memory and time; tells what went wrong."""

import json
import os
import resource
import signal
import traceback

MAX_MEMORY = 500_000_000  # [bytes] of memory more than the test's own
LONGEST = 30.0  # [s] of CPU time for one file: 2 s on the machines that this was measured on
SILENT = 300  # [s] of wall time for one file, which may wait for nothing
SAID = 5000  # characters of a sentence that refuses a file


def problems(items, load, errors):
    """Loads files one after the other; goes on in a new child where one has crashed.

    Args:
        items: list of (name, content).
        load: function of a content.
        errors: classes of the project's errors, with which it may refuse.

    Returns:
        Sentences: name, and what happened.
    """
    found, place = [], 0
    while place < len(items):
        place, said = _child(items, place, load, errors)
        found += said
    return found


def _child(items, place, load, errors):
    """Loads items from a place on in one child; returns the place to go on from, and problems."""
    source, target = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(source)
        try:
            _work(items[place:], load, errors, target)
        finally:
            os._exit(0)
    os.close(target)
    with os.fdopen(source, "rb") as stream:
        lines = [json.loads(line) for line in stream]
    _, status = os.waitpid(child, 0)
    said = [f"{items[place + number][0]}: {line}" for number, line in enumerate(lines) if line]
    place += len(lines)
    if place < len(items):
        said.append(f"{items[place][0]}: the process ended with status {status}")
    return place + 1, said


def _work(items, load, errors, target):
    with open("/proc/self/statm", encoding="ascii") as file:
        limit = int(file.read().split()[0]) * resource.getpagesize() + MAX_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for number in (signal.SIGALRM, signal.SIGPROF):
        signal.signal(number, signal.SIG_DFL)
    for _, content in items:
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
        signal.alarm(SILENT)
        line = ""
        try:
            load(content)
        except errors as error:
            line = f"a sentence of {len(str(error))} characters" if len(str(error)) > SAID else ""
        except BaseException:
            line = traceback.format_exc()[-3000:]
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        os.write(target, json.dumps(line).encode() + b"\n")
