"""Results as data: bench/results/NAME.json, one file for each section, all of one schema.

    {"format": 1, "name": "latency", "date": "2026-11-27T18:00:00+0000", "commit": "60a0a475",
     "machine": {"processor": "...", "cores": 2, "kernel": "...", "python": "3.11.2"},
     "others": 0.02,
     "figures": [{"name": "...", "value": 9.8, "unit": "ms", "runs": 9, "spread": [8.9, 11.0]}]}

`others` are processors that somebody else had, at most in any figure's rounds. `value` is the
median of the runs, `spread` their least and greatest; of one run there is no spread (null). The
unit of a ratio is "". Documents take their figures from these files.
"""

import json
import math
import os
import pathlib
import platform
import shutil
import subprocess
import time

from figures import Spread
from report import busiest
from sections import section

FOLDER = pathlib.Path(__file__).resolve().parent / "results"
FORMAT = 1
CHANGES = ("status", "--porcelain", "--", ":/", ":(top,exclude)bench/results")
KEYS = {
    "format": int,
    "name": str,
    "date": str,
    "commit": str,
    "machine": dict,
    "others": float,
    "figures": list,
}
MACHINE = {"processor": str, "cores": int, "kernel": str, "python": str}
FIGURE = {"name": str, "value": float, "unit": str, "runs": int, "spread": (list, type(None))}


def machine():
    """What figures are taken on."""
    with open("/proc/cpuinfo", encoding="utf-8") as stream:
        models = [
            line.partition(":")[2].strip() for line in stream if line.startswith("model name")
        ]
    return {
        "processor": models[0] if models else platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
        "kernel": platform.release(),
        "python": platform.python_version(),
    }


def commit():
    """Which commit is checked out, with a + if files other than results differ from it; "" outside
    of a clone and without git."""

    def git(*words):
        command = ["git", "-C", str(FOLDER.parent), *words]
        if not shutil.which("git"):
            return ""
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()

    return git("rev-parse", "--short=8", "HEAD") + ("+" if git(*CHANGES) else "")


def document(name, figures, others, date=None):
    """The document of a section.

    Args:
        figures: dict of name -> (Spread or number, unit).
        others: processors that somebody else had.
        date: text as of time.strftime; None: now.
    """
    found = []
    for label, (value, unit) in figures.items():
        spread = value if isinstance(value, Spread) else Spread.of([value])
        several = spread.count > 1
        found.append(
            {
                "name": label,
                "value": spread.median,
                "unit": unit,
                "runs": spread.count,
                "spread": [spread.least, spread.greatest] if several else None,
            }
        )
    return {
        "format": FORMAT,
        "name": name,
        "date": date or time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "commit": commit(),
        "machine": machine(),
        "others": float(others),
        "figures": found,
    }


def check(text):
    """The document that a file holds.

    Raises:
        ValueError: it is none; the message names what is wrong.
    """
    found = json.loads(text)
    _check_keys("the document", found, KEYS)
    if found["format"] != FORMAT:
        raise ValueError(f"format is {found['format']}, must be {FORMAT}")
    _check_keys("machine", found["machine"], MACHINE)
    if not found["figures"]:
        raise ValueError("figures is empty")
    names = [_check_figure(each)["name"] for each in found["figures"]]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"two figures have the name {twice!r}")
    return found


def _check_figure(figure):
    _check_keys("a figure", figure, FIGURE)
    name, runs, spread = figure["name"], figure["runs"], figure["spread"]
    if not math.isfinite(figure["value"]):
        raise ValueError(f"value of {name!r} is {figure['value']}, must be a finite number")
    if runs < 1 or (spread is None) != (runs == 1):
        raise ValueError(f"{name!r} has {runs} runs and the spread {spread}")
    if spread is not None and not (len(spread) == 2 and spread[0] <= figure["value"] <= spread[1]):
        raise ValueError(f"the spread of {name!r}, {spread}, is not around {figure['value']}")
    return figure


def _check_keys(what, found, kinds):
    if not isinstance(found, dict) or set(found) != set(kinds):
        raise ValueError(f"{what} has the keys {sorted(found)}, must have {sorted(kinds)}")
    for key, kind in kinds.items():
        if not isinstance(found[key], kind):
            raise ValueError(f"{key} of {what} is {found[key]!r}, of another type than {kind}")


def save(name, figures):
    """Write the file of a section.

    Args:
        figures: what its measure() gave.

    Returns:
        Its path.
    """
    values = {row.label: (row.value, row.unit) for row in section(name).rows(figures)
              if row.value is not None}  # fmt: skip
    text = json.dumps(document(name, values, busiest(figures)), indent=1) + "\n"
    check(text)
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / f"{name}.json"
    path.write_text(text)
    return path
