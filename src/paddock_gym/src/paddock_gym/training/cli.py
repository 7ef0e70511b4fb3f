"""python -m paddock_gym.training.cli: the process of ./run train."""

import dataclasses
import json
import os
import shutil
import sys

from paddock_gym.contract import actions, hyperparameters
from paddock_gym.contract.reward_file import RewardFile
from paddock_gym.errors import GymError, RewardError
from paddock_gym.ids import ENVS
from paddock_gym.training.settings import FILE, MAY_CHANGE, Settings


def main(arguments=None):
    """Train; returns the exit status."""
    table = json.loads((arguments or sys.argv[1:])[0])
    folder, resume, ray = table.pop("folder"), table.pop("resume"), table.pop("ray", None)
    try:
        settings = prepared(table, folder, resume)
        if resume and settings.reward != "progress":
            log(f"train: executes the reward of {settings.reward}, as the folder's {FILE} says")
        from paddock_gym.training.learn import train

        report = train(settings, folder, resume, log, ray)
    except (GymError, RewardError, ValueError) as error:
        print(f"train: {error}", file=sys.stderr)
        return 1
    log(summary(report, folder))
    return 0


def log(line):
    """Print a line immediately."""
    print(line, flush=True)


def prepared(table, folder, resume):
    """Return the checked settings of a training and create its folder.

    Args:
        table: Settings as a dict; with resume only those of the command line.

    Raises:
        GymError, TrackError: a setting is not valid.
    """
    if resume:
        settings = Settings.load(folder)
        for key, value in table.items():
            before = _plain(getattr(settings, key))
            if key not in (*MAY_CHANGE, "name") and before != value:
                raise GymError(
                    f"{key} is {value!r}, but {settings.name} was trained with {before!r}; "
                    f"only {' and '.join(MAY_CHANGE)} can change"
                )
        given = {key: value for key, value in table.items() if key in MAY_CHANGE}
        settings = dataclasses.replace(settings, **given)
    else:
        settings = Settings(**table)
        check(settings)
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
    settings.save(folder)
    return settings


def _plain(value):
    return list(value) if isinstance(value, tuple) else value


def check(settings):
    """Check the users' files before the training starts."""
    if settings.env not in ENVS:
        raise GymError(f"env is {settings.env!r}; there are {', '.join(ENVS)}")
    actions.parse(settings.metadata or "continuous")
    if settings.hyperparameters:
        hyperparameters.load(settings.hyperparameters)
    if settings.reward != "progress":
        RewardFile(settings.reward)


def summary(report, folder):
    """Text of the results and of the files in the folder."""
    if "arrived" in report:
        result = f"arrived from {report['arrived']} of {report['evaluated_starts']} unseen starts"
    else:
        mean = report["mean_lap_time"]
        result = f"{report['laps']} laps of {report['evaluated_starts']} unseen starts"
        result += f", {mean:.2f} s a lap" if mean else ""
    if "no_replay" in report:
        result += f"\ntrain: no replay: {report['no_replay']}"
    files = " ".join(sorted(name for name in os.listdir(folder) if name != FILE))
    return f"train: {result}\nin {os.path.relpath(folder)}/: {files}"


if __name__ == "__main__":
    sys.exit(main())
