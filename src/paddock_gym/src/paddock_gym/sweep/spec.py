"""What a sweep varies: its file, types of trials."""

import dataclasses
import itertools
import json
import math
import os
import sys
from dataclasses import dataclass

from cybertruck.goal.settings import GoalSettings
from paddock_common.settings import Number

from paddock_common import yaml_file
from paddock_gym.contract import hyperparameters
from paddock_gym.contract.actions import parse as parse_actions
from paddock_gym.contract.hyperparameters import one_of
from paddock_gym.envs import options as gym_options
from paddock_gym.errors import GymError
from paddock_gym.simulation import randomize
from paddock_gym.training.settings import Settings
from track_model import source

MISSED = 100.0  # what a start without a lap, or a goal not reached, counts [s]
FILE_OPTIONS = ("track", "reward", "metadata", "hyperparameters")
COUNT = Number(min=1, integer=True)
OF_FILE = (*hyperparameters.RANGES, "loss_type")  # options of a hyperparameters.json


class TrialType:
    """What a trial is: the options it takes, and how it is started.

    Attributes:
        name: in the file.
        options: their names.
    """

    name, options = "", ()

    def at_once(self):
        """Default number of parallel trials."""
        return len(os.sched_getaffinity(0))

    def with_files(self, folder, *tables):
        """Tables of options, paths among the values made absolute.

        Args:
            folder: of the sweep's file.
            tables: option -> value, or tuple of values, or Range.
        """

        def absolute(value):
            path = os.path.join(folder, value) if isinstance(value, str) else ""
            return os.path.realpath(path) if os.path.isfile(path) else value

        return [
            {
                name: values
                if name not in FILE_OPTIONS
                else tuple(map(absolute, values))
                if isinstance(values, tuple)
                else absolute(values)
                for name, values in table.items()
            }
            for table in tables
        ]

    def command(self, options, folder):
        """The program of a trial that leaves report.json in the folder."""
        table = json.dumps({"of": self.name, "options": options, "folder": folder})
        return [sys.executable, "-m", "paddock_gym.sweep.trial", table]

    def score(self, report):
        """Mean seconds of a start or a goal: the smaller, the better."""
        return report["seconds"]


class Pursuit(TrialType):
    """Gains of pure pursuit along the centreline."""

    name = "pursuit"
    options = ("lookahead", "max_speed", "max_lateral_acceleration", "track", "starts")

    def check(self, options):
        """Raise ValueError or TypeError for an option that is not valid."""
        source.find(options.get("track", "default"))
        _check(options, COUNT, "starts")
        _check(options, Number(above=0.0), *self.options[:3])


class Goal(TrialType):
    """Gains of go-to-goal."""

    name = "goal"
    options = (
        *(
            field.name
            for field in dataclasses.fields(GoalSettings)
            if field.name not in ("wheelbase", "max_steering", "hitch_offset", "tongue_length")
        ),
        "starts",
    )

    def check(self, options):
        """Raise ValueError or TypeError for an option that is not valid."""
        _check(options, COUNT, "starts")
        GoalSettings(**{name: value for name, value in options.items() if name != "starts"})


class Train(TrialType):
    """Trainings, with what ./run train takes and what a hyperparameters.json has."""

    name = "train"
    options = (
        *(field.name for field in dataclasses.fields(Settings) if field.name != "name"),
        *OF_FILE,
    )

    def at_once(self):
        """One: a training has workers of its own."""
        return 1

    def check(self, options):
        """Raise ValueError or TypeError for an option that is not valid."""
        _check(options, COUNT, "steps", "workers")
        _check(options, Number(min=0, integer=True), "seed")
        chosen = self.settings(options, "")
        source.find(chosen.track)
        gym_options.parse(
            chosen.observation, "continuous", chosen.reward, chosen.race, chosen.randomize, False
        )
        parse_actions(chosen.metadata or "continuous")
        if chosen.hyperparameters:
            hyperparameters.load(chosen.hyperparameters)
        hyperparameters.parse("over", {key: options[key] for key in OF_FILE if key in options})

    def settings(self, options, folder):
        """Settings of a training.

        Args:
            folder: for its hyperparameters.json; "": none is written.
        """
        table = {key: value for key, value in options.items() if key not in OF_FILE}
        if "observation" in table:
            value = table["observation"]
            table["observation"] = value.split(",") if isinstance(value, str) else value
        if "randomize" in table:
            table["randomize"] = randomize.parse(table["randomize"])
        own = {key: options[key] for key in OF_FILE if key in options}
        if own and folder:
            base = table.get("hyperparameters")
            if base:
                own = {**hyperparameters.load_json(base), **own}
            table["hyperparameters"] = os.path.join(folder, "hyperparameters.json")
            hyperparameters.write_json(table["hyperparameters"], own)
        return Settings(name=os.path.basename(folder), **table)

    def command(self, options, folder):
        """The program of a trial that leaves report.json in the folder."""
        settings = self.settings(options, os.path.dirname(folder))
        table = dict(dataclasses.asdict(settings), folder=folder, resume=False)
        return [sys.executable, "-m", "paddock_gym.training.cli", json.dumps(table)]

    def score(self, report):
        """Mean seconds of a start: the smaller, the better."""
        times = report["lap_times"]
        count = report["evaluated_starts"]
        return (sum(times) + MISSED * (count - len(times))) / count


def _check(options, rule, *names):
    """Check those of some options that are there."""
    for name in names:
        if name in options:
            rule.check(name, options[name], GymError)


TRIAL_TYPES = {trial_type.name: trial_type for trial_type in (Train(), Pursuit(), Goal())}


KEYS = ("of", "search", "trials", "seed", "at_once", "fixed", "over")
SEARCHES = ("grid", "random", "tpe")
MAX_TRIALS = 10_000  # trials
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
        at_once: parallel trials.
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
        GymError: it is not valid; the message names file, key, value and what is valid.
    """
    data = _read(path)
    for key in data:
        if key not in KEYS:
            raise GymError(f"{path}: unknown key {key!r}; there are {', '.join(KEYS)}")
    of = one_of(path, "of", data.get("of"), tuple(TRIAL_TYPES))
    fixed, over_table = _table(path, "fixed", data), _table(path, "over", data)
    if not over_table:
        raise GymError(f"{path}: over is missing; it must be a table of options and their values")
    over = {name: _values(path, name, values) for name, values in over_table.items()}
    ranges = [name for name, values in over.items() if isinstance(values, Range)]
    search = one_of(path, "search", data.get("search", "tpe" if ranges else "grid"), SEARCHES)
    if search == "grid" and ranges:
        raise GymError(f"{path}: over: {ranges[0]} is a range; a grid needs a list of values")
    count = math.prod(1 if isinstance(values, Range) else len(values) for values in over.values())
    if search == "grid" and "trials" in data:
        raise GymError(f"{path}: trials is {data['trials']!r}; a grid has {count}, remove the key")
    trials = count if search == "grid" else _integer(path, data, "trials", 20, 1, MAX_TRIALS)
    trial_type = TRIAL_TYPES[of]
    at_once = _integer(path, data, "at_once", trial_type.at_once(), 1, 1000)
    seed = _integer(path, data, "seed", 0, 0, 2**31)
    folder = os.path.dirname(os.path.abspath(path))
    spec = Spec(of, search, trials, seed, at_once, *trial_type.with_files(folder, fixed, over))
    for name in (*fixed, *over):
        if name not in trial_type.options:
            valid = ", ".join(trial_type.options)
            raise GymError(f"{path}: {name} is no option of {of}; there are {valid}")
    both = sorted({*fixed} & {*over})
    if both:
        raise GymError(f"{path}: {both[0]} is in fixed and in over; it must be in one of them")
    for options in _corners(spec):
        try:
            trial_type.check(options)
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
        text, keys = yaml_file.formatted(data), ", ".join(KEYS)
        raise GymError(f"{path} contains {text}; it must be a table with {keys}")
    return data


def _table(path, key, data):
    table = data.get(key) or {}
    if not isinstance(table, dict) or not all(isinstance(name, str) for name in table):
        raise GymError(
            f"{path}: {key} is {yaml_file.formatted(table)}; it must be a table of options"
        )
    return table


def _values(path, name, values):
    """A tuple of values, or a Range."""
    if isinstance(values, dict):
        return _range(path, name, values)
    if not isinstance(values, list) or not values:
        raise GymError(
            f"{path}: over: {name} is {yaml_file.formatted(values)}; it must be a list of values, "
            "or low and high"
        )
    return tuple(values)


def _range(path, name, values):
    keys = ("low", "high", "log")
    limits = [values.get(key) for key in keys[:2]]
    numbers = all(isinstance(limit, (int, float)) and abs(limit) < LARGEST for limit in limits)
    log = values.get("log", False)
    if not (
        set(values) <= set(keys) and numbers and limits[0] < limits[1] and isinstance(log, bool)
    ) or (log and limits[0] <= 0):
        raise GymError(
            f"{path}: over: {name} is {yaml_file.formatted(values)}; it must have low and high, "
            "low the smaller, and may have log: true, with low above 0"
        )
    return Range(*limits, log, all(isinstance(limit, int) for limit in limits))


def _integer(path, data, key, default, minimum, maximum):
    rule = Number(min=minimum, max=maximum, integer=True)
    return rule.check(f"{path}: {key}", data.get(key, default), GymError)
