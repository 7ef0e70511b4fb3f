"""Speed of the simulator as its users meet it: JSON on stdout and in out/bench/bench.json.

Results that are kept go to bench/results/ with --save.
"""

import argparse
import json
import os
import pathlib
import signal
import sys
import time

import results
from figures import BenchError
from report import table
from sections import SECTIONS, section

ROOT = pathlib.Path(os.environ.get("PADDOCK_ROOT", pathlib.Path(__file__).resolve().parents[1]))
sys.path.append(str(ROOT))  # for the package commands
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def run(names, quick, log, save=False):
    """The figures of some sections; a section that fails says why and the others go on.

    Args:
        save: bool, whether each section's results are written as soon as it has ended.
    """
    result = {
        "quick": quick,
        "machine": results.machine(),
        "load_average": os.getloadavg(),
        "date": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "errors": {},
    }
    for name in names:
        begin = time.monotonic()
        print(f"bench: {name} ...", file=sys.stderr, flush=True)
        try:
            figures = section(name).measure(quick, log)
            errors = {f"{name} {part}": text for part, text in figures.pop("errors", {}).items()}
            if figures:
                result[name] = figures
            if figures and save:
                print(f"bench: wrote {results.save(name, figures)}", file=sys.stderr)
        except BenchError as error:
            errors = {name: str(error)}
        for part, text in errors.items():
            print(f"bench: {part}: {text}; see {log.name}", file=sys.stderr)
        result["errors"].update(errors)
        print(f"bench: {name} took {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
    return result


def measure(names, quick, save):
    """Measure, write, tell; returns the exit code."""
    folder = ROOT / "out" / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "bench.log", "w") as log:
        result = run(names, quick, log, save)
    text = json.dumps(result, indent=2)
    (folder / "bench.json").write_text(text + "\n")
    print(text)
    print(table(result), file=sys.stderr)
    return 1 if result["errors"] else 0


def stop(number, _frame):
    """Ends the bench in order at a first signal: worlds that it has started end, too."""
    for other in STOP_SIGNALS:
        signal.signal(other, signal.SIG_IGN)
    print("bench: interrupted", file=sys.stderr, flush=True)
    raise SystemExit(128 + number)


def main():
    """Measure; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="./run bench --",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="sections:\n" + "\n".join(f"  {name:12} {text}" for name, text in SECTIONS.items()),
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="short rounds, fewer pairs and variants: to see that all works",
    )
    parser.add_argument("--only", nargs="+", choices=SECTIONS, metavar="SECTION")
    parser.add_argument(
        "--save", action="store_true", help="write each section's results to bench/results/"
    )
    arguments = parser.parse_args()
    if arguments.save and arguments.quick:
        parser.error("--save and --quick: the figures of a quick run are not to be quoted")
    for number in STOP_SIGNALS:
        signal.signal(number, stop)
    return measure(arguments.only or list(SECTIONS), arguments.quick, arguments.save)


if __name__ == "__main__":
    sys.exit(main())
