"""python -m paddock_gym.sweep.cli: the process of ./run sweep."""

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
    """Run a sweep, or the rest of it.

    Returns:
        0, or 130 after Ctrl-C, SIGTERM or SIGHUP.
    """
    for signal_number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(signal_number, signal.default_int_handler)
    sweep_spec = spec.load(file)
    study = Study(sweep_spec, folder, log)
    status = 0
    try:
        study.run()
    except KeyboardInterrupt:
        log("sweep: interrupted; the same command continues")
        status = 130
    finally:
        rows, names = study.rows(), list(sweep_spec.over)
        if rows:
            report.write(rows, names, folder)
    if rows:
        log(report.text_table(rows, names))
        files = " ".join(sorted(name for name in os.listdir(folder) if name != SPEC))
        log(f"in {os.path.relpath(folder)}/: {files}")
    return status


def log(line):
    """Print a line immediately."""
    print(line, flush=True)


if __name__ == "__main__":
    sys.exit(main())
