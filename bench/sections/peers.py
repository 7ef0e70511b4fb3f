"""Paddock's environments beside other simulators of cars; no ROS.

The others are no part of Paddock: the environment variable PADDOCK_PEERS is a folder with virtual
environments mujoco, racecar, f1tenth and box2d, in which they are installed as bench/others.py
--help says. One that is not there is left out. All drive round a circle, each by its own API.
"""

import os
import pathlib
import sys

import others
from figures import Spread
from report import Row


def pythons(errors):
    """kind -> Python of each simulator that is there.

    Args:
        errors: dict; gets why others are not.
    """
    found, folder = {"paddock": sys.executable}, os.environ.get("PADDOCK_PEERS")
    for kind in others.INSTALL:
        python = str(pathlib.Path(folder, kind, "bin", "python")) if folder else ""
        reason = others.missing(kind, python)
        if reason:
            errors[kind] = reason
        else:
            found[kind] = python
    return found


def measure(quick, log):
    """What others.measure finds of all that are there."""
    errors = {}
    found = others.measure(pythons(errors), quick)
    for line in others.lines(found):
        print(line, file=log, flush=True)
    return {"subjects": found, "errors": errors}


def rows(figures):
    """Of each subject car seconds a second of processor time; ratios of those that see alike."""
    found = figures["subjects"]
    for name in (others.REFERENCE, *found):
        own = others.own(found, name)
        yield Row(name, f"{own.text('.1f')}, {others.SUBJECTS[name][1]}", own, "car s a core s")
    for name, about in found.items():
        if about["cars"] > 1:
            pace = Spread.read(about["variant"]).median * about["period"] * about["cars"]
            yield Row(f"{name}, all cores", f"{pace:.1f} car seconds a second", pace, "car s a s")
    for mine, its in others.BESIDE:
        if its in found:
            ratio = others.over(found, mine, its)
            yield Row(f"{mine} over {its}", ratio.text(), ratio)
