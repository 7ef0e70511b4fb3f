"""What can be swept: trainings, gains of pure pursuit, gains of the Cyber Truck's go-to-goal."""

import dataclasses
import json
import os
import sys

from cybertruck.goal.settings import GoalSettings
from paddock_common.rules import Number

from paddock_gym.contract import hyperparameters
from paddock_gym.contract.actions import parse as parse_actions
from paddock_gym.envs import options as gym_options
from paddock_gym.errors import GymError
from paddock_gym.simulation.randomize import KINDS as RANDOM
from paddock_gym.training.settings import Settings
from track_model import source

MISSED = 100.0  # what a start without a lap, or a goal not reached, counts [s]
FILE_OPTIONS = ("track", "reward", "metadata", "hyperparameters")
COUNT = Number(least=1, whole=True)
OF_FILE = (*hyperparameters.RANGES, "loss_type")  # options of a hyperparameters.json


class Kind:
    """What a trial is: the options it takes, and how it is started.

    Attributes:
        name: as the file says it.
        options: their names.
    """

    name, options = "", ()

    def at_once(self):
        """Trials side by side, unless the file says it."""
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


class Pursuit(Kind):
    """Gains of pure pursuit along the centreline."""

    name = "pursuit"
    options = ("lookahead", "max_speed", "max_lateral_acceleration", "track", "starts")

    def check(self, options):
        """Raise what is wrong."""
        source.find(options.get("track", "default"))
        _check(options, COUNT, "starts")
        _check(options, Number(above=0.0), *self.options[:3])


class Goal(Kind):
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
        """Raise what is wrong."""
        _check(options, COUNT, "starts")
        GoalSettings(**{name: value for name, value in options.items() if name != "starts"})


class Train(Kind):
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
        """Raise what is wrong."""
        _check(options, COUNT, "steps", "workers")
        _check(options, Number(least=0, whole=True), "seed")
        chosen = self.settings(options, "")
        source.find(chosen.track)
        if set(chosen.randomize) - set(RANDOM):
            raise GymError(f"randomize is {options['randomize']!r}; there are {', '.join(RANDOM)}")
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
            options: of the trial.
            folder: for its hyperparameters.json; "": none is written.
        """
        table = {key: value for key, value in options.items() if key not in OF_FILE}
        for key in ("observation", "randomize"):
            if key in table:
                value = table[key]
                table[key] = tuple(value.split(",") if isinstance(value, str) else value)
        own = {key: options[key] for key in OF_FILE if key in options}
        if own and folder:
            base = table.get("hyperparameters")
            if base:
                with open(base, encoding="utf-8") as stream:
                    own = {**json.load(stream), **own}
            table["hyperparameters"] = os.path.join(folder, "hyperparameters.json")
            with open(table["hyperparameters"], "w", encoding="utf-8") as stream:
                json.dump(own, stream)
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


KINDS = {kind.name: kind for kind in (Train(), Pursuit(), Goal())}
