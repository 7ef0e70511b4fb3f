"""python -m paddock_gym.evaluation.cli: the process of ./run evaluate."""

import json
import os
import shutil
import sys

import numpy as np

from paddock_gym.contract.actions import Continuous
from paddock_gym.contract.hyperparameters import write_json
from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.errors import GymError
from paddock_gym.evaluation import backing, plots
from paddock_gym.evaluation.laps import DRIVERS, PolicyDriver, drive, line_to_line, starts
from paddock_gym.ids import BACKING
from paddock_gym.policy.onnx_policy import OnnxPolicy

HEAD = (
    "track", "driver", "laps", "lap time [s]", "line to line [s]", "off the centreline [cm]",
    "other ends",
)  # fmt: skip


def main(arguments=None):
    """Evaluate; returns the exit status."""
    table = json.loads((arguments or sys.argv[1:])[0])
    try:
        rows = evaluate(**table)
    except (GymError, ValueError) as error:
        print(f"evaluate: {error}", file=sys.stderr)
        return 1
    print(aligned(backing.lines(rows) if "arrived" in rows[0] else lines(rows)))
    print(
        f"in {os.path.relpath(table['folder'])}/: {' '.join(sorted(os.listdir(table['folder'])))}"
    )
    return 0


def evaluate(policy, tracks, starts, walls, folder):
    """Run all drivers on all tracks; writes report.json and an image for each track.

    Args:
        tracks: names or paths; empty: the track of its training.
        starts: how many of each driver on each track.
        walls: as the environment's option.
        folder: for the files; its content is deleted.

    Returns:
        Rows (dicts), one per track and driver.
    """
    about = OnnxPolicy(policy, env=None).description
    if about.env == BACKING and tracks:
        raise GymError(f"track is {tracks[0]!r}; a policy for backing has no track")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    rows = []
    if about.env == BACKING:
        rows = backing.compare(policy, starts)
    else:
        for track in tracks or [about.track]:
            rows += on_track(policy, about, track, starts, walls, folder)
    write_json(os.path.join(folder, "report.json"), rows)
    return rows


def on_track(policy, about, track, count, walls, folder):
    """Rows of all drivers on one track."""
    names = about.observations
    observation = names[0] if len(names) == 1 else names
    rows = []
    for name in ("policy", *DRIVERS):
        mine = name == "policy"
        # other drivers choose speeds and angles freely, whatever the policy's actions are
        env = DeepRacerEnv(
            track,
            observation if mine else "state",
            action=about.actions if mine else Continuous(),
            race=about.race,
            control_rate=about.control_rate,
            walls=walls,
            colour=about.colour,
        )
        driver = PolicyDriver(policy) if mine else DRIVERS[name]()
        laps = [drive(env, driver, start, seed=k) for k, start in enumerate(starts(count))]
        rows.append(summary(env.task.track.name, name, laps))
        rows[-1]["line_to_line"] = line_to_line(env, driver)
        if mine:
            path = os.path.join(folder, f"{env.task.track.name}.png")
            plots.paths(laps, env.task.track, path)
        env.close()
    return rows


def summary(track, driver, laps):
    """Report of the starts of a driver on a track."""
    times = [lap.time for lap in laps if lap.is_lap]
    return {
        "track": track,
        "driver": driver,
        "starts": len(laps),
        "laps": len(times),
        "lap_times": [round(seconds, 3) for seconds in times],
        "rms_lateral": round(float(np.sqrt(np.mean([lap.rms_lateral**2 for lap in laps]))), 4),
        "max_lateral": round(max(lap.max_lateral for lap in laps), 4),
        "other_ends": [lap.end for lap in laps if not lap.is_lap],
    }


def lines(rows):
    """Cells of the table of rows, with its head."""
    table = [HEAD]
    for row in rows:
        times = row["lap_times"]
        spread = f"{np.mean(times):.2f} ({min(times):.2f} to {max(times):.2f})" if times else "-"
        table.append(
            (
                row["track"],
                row["driver"],
                f"{row['laps']} of {row['starts']}",
                spread,
                "-" if row["line_to_line"] is None else f"{row['line_to_line']:.2f}",
                f"{100 * row['rms_lateral']:.1f}, at most {100 * row['max_lateral']:.1f}",
                ", ".join(sorted(set(row["other_ends"]))) or "-",
            )
        )
    return table


def aligned(table):
    """Text of a table: rows of cells, columns aligned."""
    widths = [max(map(len, column)) for column in zip(*table)]
    return "\n".join("  ".join(f"{cell:{w}}" for cell, w in zip(row, widths)) for row in table)


if __name__ == "__main__":
    sys.exit(main())
