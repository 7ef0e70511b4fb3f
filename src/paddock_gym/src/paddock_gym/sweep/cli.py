"""python -m paddock_gym.sweep.cli: what ./run sweep becomes."""

import json
import os
import signal
import sys

from paddock_gym.errors import GymError
from paddock_gym.sweep import report, spec
from paddock_gym.sweep.study import SPEC, Study


def main(arguments=None):
    """Sweep; returns the exit status."""
    table = json.loads((arguments or sys.argv[1:])[0])
    try:
        return sweep(table["file"], table["folder"])
    except (GymError, ValueError) as error:
        print(f"sweep: {error}", file=sys.stderr)
        return 1


def sweep(file, folder):
    """Do a sweep, or what is left of it.

    Args:
        file: its YAML.
        folder: for its files.

    Returns:
        0, or 130 after Ctrl-C, SIGTERM or SIGHUP.
    """
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)
    chosen = spec.load(file)
    study = Study(chosen, folder, say)
    status = 0
    try:
        study.run()
    except KeyboardInterrupt:
        say("sweep: interrupted; the same command goes on")
        status = 130
    finally:
        rows, names = study.rows(), list(chosen.over)
        if rows:
            report.write(rows, names, folder)
    if rows:
        say(report.text_table(rows, names))
        files = " ".join(sorted(name for name in os.listdir(folder) if name != SPEC))
        say(f"in {os.path.relpath(folder)}/: {files}")
    return status


def say(line):
    """Print a line at once."""
    print(line, flush=True)


if __name__ == "__main__":
    sys.exit(main())
