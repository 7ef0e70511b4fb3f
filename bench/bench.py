"""Speed of the simulator as its users meet it: JSON on stdout and in out/bench/bench.json."""

import argparse
import json
import os
import pathlib
import platform
import signal
import sys
import time

from figures import BenchError
from report import merged, read_sessions, table
from sections import SECTIONS, section

ROOT = pathlib.Path(os.environ.get("PADDOCK_ROOT", pathlib.Path(__file__).resolve().parents[1]))
FORMAT = 2  # of bench.json
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def machine():
    """What the figures were taken on."""
    model = next(
        (
            line.split(":", 1)[1].strip()
            for line in open("/proc/cpuinfo")
            if line.startswith("model name")
        ),
        platform.machine(),
    )
    return {
        "cpu": model,
        "cpus": len(os.sched_getaffinity(0)),
        "kernel": platform.release(),
        "python": platform.python_version(),
    }


def run(names, quick, log):
    """The figures of some sections; a section that fails says why and the others go on."""
    result = {
        "format": FORMAT,
        "quick": quick,
        "machine": machine(),
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
        except BenchError as error:
            errors = {name: str(error)}
        for part, text in errors.items():
            print(f"bench: {part}: {text}; see {log.name}", file=sys.stderr)
        result["errors"].update(errors)
        print(f"bench: {name} took {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
    return result


def measure(names, quick, files):
    """Measure, write, tell; returns the exit code."""
    folder = ROOT / "out" / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "bench.log", "w") as log:
        result = run(names, quick, log)
    text = json.dumps(result, indent=2)
    for file in (folder / "bench.json", *files):
        file.write_text(text + "\n")
    for name in names:
        draw = getattr(section(name), "draw", None)
        if draw is not None and name in result:
            draw(result[name], folder)
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
    """Measure, or merge sessions; returns the exit code."""
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
        "--save", type=pathlib.Path, metavar="FILE", help="also write the JSON here, for --sessions"
    )
    parser.add_argument(
        "--sessions",
        "--sittings",
        nargs="+",
        type=pathlib.Path,
        metavar="FILE",
        help="measure nothing; put the figures of several runs in one table",
    )
    arguments = parser.parse_args()
    if arguments.sessions:
        try:
            print(merged(read_sessions(arguments.sessions, FORMAT)))
        except ValueError as error:
            parser.error(str(error))
        return 0
    for number in STOP_SIGNALS:
        signal.signal(number, stop)
    return measure(
        arguments.only or list(SECTIONS),
        arguments.quick,
        [arguments.save] if arguments.save else [],
    )


if __name__ == "__main__":
    sys.exit(main())
