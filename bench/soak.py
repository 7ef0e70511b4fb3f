"""World, car, truck, camera, lidars and window under faults for as long as you like."""

import argparse
import json
import os
import pathlib
import signal
import sys
import time

from soaking import environments, report, shutdown
from soaking.run import Soak

ROOT = pathlib.Path(os.environ.get("PADDOCK_ROOT", pathlib.Path(__file__).resolve().parents[1]))
OUT = ROOT / "out" / "soak"


def minutes(text):
    """Reads a time.

    Raises:
        argparse.ArgumentTypeError: It is no number above 0.
    """
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= 10000.0:
        raise argparse.ArgumentTypeError(
            f"minutes is {text!r}; it must be a number above 0, at most 10000"
        )
    return value


def say(line):
    """Prints a line of progress at once."""
    print(line, flush=True)


def stop_worlds(count, seed, folder):
    """Starts and stops worlds; returns the exit status."""
    folder.mkdir(parents=True, exist_ok=True)
    results = shutdown.run(count, seed, folder, say)
    lines = shutdown.table(results, shutdown.SIGNALS)
    (folder / "stops.json").write_text(json.dumps(results, indent=2) + "\n")
    (folder / "stops.md").write_text("\n".join(lines) + "\n")
    bad = [result for result in results if result["problem"]]
    slowest = max((result["seconds"] for result in results), default=0.0)
    say("\n" + "\n".join(lines))
    say(f"{len(results)} stops, {len(bad)} failed, the longest took {slowest:.1f} s")
    return 1 if bad else 0


def main():
    """Runs a soak; returns the exit status."""
    parser = argparse.ArgumentParser(prog="./run soak", description=__doc__)
    parser.add_argument(
        "--minutes", type=minutes, default=10.0, metavar="N", help="how long it goes on (10)"
    )
    parser.add_argument(
        "--seed", type=int, metavar="S", help="of the order of faults (the time of day)"
    )
    parser.add_argument(
        "--stops",
        type=int,
        metavar="N",
        help="start and stop N worlds instead, in each state by each signal",
    )
    parser.add_argument(
        "--machine",
        nargs="*",
        choices=environments.TRIALS,
        metavar="TRIAL",
        help="try full disks, small limits and odd homes instead (as root)",
    )
    parser.add_argument(
        "--folder", type=pathlib.Path, help="of the results (out/soak/, or seed-S in it)"
    )
    options = parser.parse_args()
    seed = int(time.time()) % 100000 if options.seed is None else options.seed
    # SIGINT, too: who starts this in the background may ignore it, and worlds would inherit that.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)
    if options.machine is not None:
        failed = environments.run(options.machine, options.folder or OUT / "machine", say)
        return 1 if failed else 0
    if options.stops is not None:
        return stop_worlds(options.stops, seed, options.folder or OUT)
    folder = options.folder or OUT / f"seed-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    print(f"seed {seed}, {options.minutes:g} minutes; results go to {folder}", flush=True)
    soak = Soak(options.minutes, seed, folder, say)
    try:
        soak.run()
    except KeyboardInterrupt:
        print("interrupted; what there is follows", flush=True)
    bad = report.write(soak.timeline, folder, options.minutes)
    for failure in bad:
        print(f"FAILED {failure}")
    print(f"{'FAILED' if bad else 'ok'}: {folder / 'soak.md'}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
