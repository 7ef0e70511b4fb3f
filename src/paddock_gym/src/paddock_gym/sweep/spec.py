"""The file of a sweep, checked before anything long begins."""

import itertools
import math
import os
from dataclasses import dataclass

from paddock_common.files import yaml_file
from paddock_common.rules import Number

from paddock_gym.contract.json_file import one_of
from paddock_gym.errors import GymError
from paddock_gym.sweep.kinds import KINDS

KEYS = ("of", "search", "trials", "seed", "at_once", "fixed", "over")
SEARCHES = ("grid", "random", "tpe")
MOST = 10_000  # trials
LARGEST = 1e300  # end of a range


@dataclass(frozen=True)
class Range:
    """Numbers between two ends.

    Attributes:
        low, high: ends.
        log: whether ratios count, not differences.
        whole: whether they are whole numbers.
    """

    low: float
    high: float
    log: bool = False
    whole: bool = False


@dataclass(frozen=True)
class Spec:
    """What a sweep is.

    Attributes:
        of: name of KINDS.
        search: name of SEARCHES.
        trials: how many.
        seed: of the search.
        at_once: trials side by side.
        fixed: option -> value.
        over: option -> tuple of values, or Range.
    """

    of: str
    search: str
    trials: int
    seed: int
    at_once: int
    fixed: dict
    over: dict


def load(path):
    """Read a sweep's file.

    Raises:
        GymError: it is wrong; one sentence names file, key, value and what is valid.
    """
    data = _read(path)
    for key in data:
        if key not in KEYS:
            raise GymError(f"{path}: unknown key {key!r}; there are {', '.join(KEYS)}")
    of = one_of(path, "of", data.get("of"), tuple(KINDS))
    fixed, given = _table(path, "fixed", data), _table(path, "over", data)
    if not given:
        raise GymError(f"{path}: over is missing; it must be a table of options and their values")
    over = {name: _values(path, name, values) for name, values in given.items()}
    ranges = [name for name, values in over.items() if isinstance(values, Range)]
    search = one_of(path, "search", data.get("search", "tpe" if ranges else "grid"), SEARCHES)
    if search == "grid" and ranges:
        raise GymError(f"{path}: over: {ranges[0]} is a range; a grid needs a list of values")
    count = math.prod(1 if isinstance(values, Range) else len(values) for values in over.values())
    if search == "grid" and "trials" in data:
        raise GymError(f"{path}: trials is {data['trials']!r}; a grid has {count}, leave it out")
    trials = count if search == "grid" else _whole(path, data, "trials", 20, 1, MOST)
    kind = KINDS[of]
    at_once = _whole(path, data, "at_once", kind.at_once(), 1, 1000)
    seed = _whole(path, data, "seed", 0, 0, 2**31)
    folder = os.path.dirname(os.path.abspath(path))
    spec = Spec(of, search, trials, seed, at_once, *kind.with_files(folder, fixed, over))
    for name in (*fixed, *over):
        if name not in kind.options:
            valid = ", ".join(kind.options)
            raise GymError(f"{path}: {name} is no option of {of}; there are {valid}")
    both = sorted({*fixed} & {*over})
    if both:
        raise GymError(f"{path}: {both[0]} is in fixed and in over; it must be in one of them")
    for options in _corners(spec):
        try:
            kind.check(options)
        except (ValueError, TypeError) as error:
            raise GymError(f"{path}: {error}") from error
    return spec


def _corners(spec):
    """Options to check: every value of every option, the others being first ones."""
    listed = {
        name: (values.low, values.high) if isinstance(values, Range) else values
        for name, values in spec.over.items()
    }
    first = {name: values[0] for name, values in listed.items()}
    pairs = itertools.chain.from_iterable(
        ((name, value) for value in values) for name, values in listed.items()
    )
    return [{**spec.fixed, **first, name: value} for name, value in pairs]


def _read(path):
    try:
        data = yaml_file.read(path)
    except ValueError as error:
        raise GymError(f"{error}; it must be a readable YAML file") from error
    if not isinstance(data, dict):
        held, keys = yaml_file.shown(data), ", ".join(KEYS)
        raise GymError(f"{path} holds {held}; it must be a table with {keys}")
    return data


def _table(path, key, data):
    table = data.get(key) or {}
    if not isinstance(table, dict) or not all(isinstance(name, str) for name in table):
        raise GymError(f"{path}: {key} is {yaml_file.shown(table)}; it must be a table of options")
    return table


def _values(path, name, values):
    """A tuple of values, or a Range."""
    if isinstance(values, dict):
        return _range(path, name, values)
    if not isinstance(values, list) or not values:
        raise GymError(
            f"{path}: over: {name} is {yaml_file.shown(values)}; it must be a list of values, or "
            "low and high"
        )
    return tuple(values)


def _range(path, name, values):
    keys = ("low", "high", "log")
    ends = [values.get(key) for key in keys[:2]]
    numbers = all(isinstance(end, (int, float)) and abs(end) < LARGEST for end in ends)
    log = values.get("log", False)
    if not (
        set(values) <= set(keys) and numbers and ends[0] < ends[1] and isinstance(log, bool)
    ) or (log and ends[0] <= 0):
        raise GymError(
            f"{path}: over: {name} is {yaml_file.shown(values)}; it must have low and high, low "
            "the smaller, and may have log: true, with low above 0"
        )
    return Range(*ends, log, all(isinstance(end, int) for end in ends))


def _whole(path, data, key, default, least, most):
    rule = Number(least=least, most=most, whole=True)
    return rule.check(f"{path}: {key}", data.get(key, default), GymError)
