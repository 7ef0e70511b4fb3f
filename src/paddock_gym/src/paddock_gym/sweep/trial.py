"""Trials of a sweep, and their processes."""

import json
import os
import signal
import subprocess
import sys
import threading

import numpy as np

from paddock_gym.contract.hyperparameters import write_json
from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.evaluation import goals
from paddock_gym.evaluation.laps import PursuitDriver, drive, starts
from paddock_gym.sweep.spec import MISSED


class Processes:
    """Runs processes, one per calling thread."""

    def __init__(self):
        self._lock, self._running, self._stopped = threading.Lock(), set(), False

    def run(self, command, log):
        """Run a program until it exits.

        Args:
            log: path of the file for what it prints.

        Returns:
            Its exit status; None: stop() was called.
        """
        with open(log, "w", encoding="utf-8") as stream:
            with self._lock:
                if self._stopped:
                    return None
                process = subprocess.Popen(
                    command, stdout=stream, stderr=stream, start_new_session=True
                )
                self._running.add(process)
            status = process.wait()
        with self._lock:
            self._running.discard(process)
            return None if self._stopped else status

    def stop(self):
        """Kill all running processes with their children, and start no more."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                try:
                    os.killpg(process.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass  # it has exited


def main(arguments=None):
    """Drive; returns the exit status."""
    table = json.loads((arguments or sys.argv[1:])[0])
    report = WORK[table["of"]](dict(table["options"]))
    os.makedirs(table["folder"], exist_ok=True)
    write_json(os.path.join(table["folder"], "report.json"), report)
    return 0


def pursuit(options):
    """Laps of pure pursuit; returns the report."""
    track, count = options.pop("track", "default"), options.pop("starts", 10)
    env = DeepRacerEnv(track, control_rate=20.0)
    driver = PursuitDriver(**options)
    laps = [drive(env, driver, start, seed=k) for k, start in enumerate(starts(count))]
    env.close()
    return {
        "starts": count,
        "good": sum(lap.is_lap for lap in laps),
        "seconds": mean(lap.time if lap.is_lap else MISSED for lap in laps),
        "rms_lateral": mean(lap.rms_lateral for lap in laps),
        "ends": [lap.end for lap in laps],
    }


def goal(options):
    """Drives to goals; returns the report."""
    count = options.pop("starts", 10)
    drives = goals.drive_all(goals.goals(count), **options)
    return {
        "starts": count,
        "good": sum(drive.is_good for drive in drives),
        "seconds": mean(drive.time if drive.is_good else MISSED for drive in drives),
        "detour": mean(drive.detour for drive in drives),
        "distance": mean(drive.distance for drive in drives),
        "ends": [drive.end for drive in drives],
    }


def mean(values):
    """The mean, as a float of JSON."""
    return round(float(np.mean(list(values))), 4)


WORK = {"pursuit": pursuit, "goal": goal}

if __name__ == "__main__":
    sys.exit(main())
