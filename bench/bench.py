"""Speed of the simulator as its users meet it: JSON on stdout and in out/bench/bench.json."""

import argparse
import json
import os
import pathlib
import platform
import sys
import time

from curves import draw_all
from figures import BenchError
from report import table
from sections import SECTIONS

ROOT = pathlib.Path(os.environ.get("PADDOCK_ROOT", pathlib.Path(__file__).resolve().parents[1]))


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
            result[name] = SECTIONS[name](quick, log)
        except BenchError as error:
            result["errors"][name] = str(error)
            print(f"bench: {name}: {error}; see {log.name}", file=sys.stderr)
        print(f"bench: {name} took {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
    return result


def main():
    """Measure, write, tell; returns the exit code."""
    parser = argparse.ArgumentParser(prog="./run bench --", description=__doc__)
    parser.add_argument(
        "--quick",
        action="store_true",
        help="some three minutes: short windows, one start, fewer variants",
    )
    parser.add_argument(
        "--only", nargs="+", choices=SECTIONS, metavar="SECTION", help=", ".join(SECTIONS)
    )
    arguments = parser.parse_args()
    folder = ROOT / "out" / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "bench.log", "w") as log:
        result = run(arguments.only or list(SECTIONS), arguments.quick, log)
    text = json.dumps(result, indent=2)
    (folder / "bench.json").write_text(text + "\n")
    draw_all(result, folder)
    print(text)
    print(table(result), file=sys.stderr)
    return 1 if result["errors"] else 0


if __name__ == "__main__":
    sys.exit(main())
