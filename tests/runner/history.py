"""What the last runs found: failed jobs, flaky jobs, wall times."""

import json

from runner.job import RESULTS

FILE = RESULTS / "history.json"
LENGTH = 10  # runs of a job that are kept
# Of jobs that nothing is known of [s].
STAGE_SECONDS = {
    "unit": 20.0,
    "lint": 5.0,
    "ros": 15.0,
    "soak": 150.0,
    "learning": 300.0,
    "desk": 100.0,
    "tutorials": 300.0,
    "long": 60.0,
}
# Jobs that take longer on two cores [s]; own runs replace them.
SECONDS = {
    "unit project": 150.0,
    "unit bullet_sim": 100.0,
    "ros check": 100.0,
    "ros lap_drivers": 100.0,
    "ros lap_run": 80.0,
    "ros goal_trailer": 70.0,
    "ros back_faults": 60.0,
    "ros keyboard": 60.0,
    "ros keyboard_x": 60.0,
    "ros keyboard_starts": 40.0,
    "ros joystick": 30.0,
}


class History:
    """The last results of each job, newest last.

    Args:
        file: JSON file; need not exist.
    """

    def __init__(self, file=FILE):
        self._file = file
        try:
            self._runs = dict(json.loads(file.read_text(encoding="utf-8")))
        except (OSError, ValueError):  # none yet, or cut off
            self._runs = {}

    def add(self, key, outcome):
        """Keeps what came of a job, at once.

        Args:
            key: The job's.
            outcome: Its Outcome.
        """
        run = {
            "ok": not outcome.failures,
            "seconds": round(outcome.seconds, 1),
            "cpu": round(outcome.cpu),
        }
        self._runs[key] = [*self._runs.get(key, []), run][-LENGTH:]
        self._file.parent.mkdir(parents=True, exist_ok=True)
        part = self._file.with_suffix(".part")
        part.write_text(json.dumps(self._runs), encoding="utf-8")
        part.replace(self._file)

    def failed(self):
        """Gives the keys of the jobs that failed when they last ran."""
        return {key for key, runs in self._runs.items() if not runs[-1]["ok"]}

    def flaky(self):
        """Gives key -> (failed, runs) of jobs that have failed and passed in the last runs."""
        counts = {
            key: (sum(not run["ok"] for run in runs), len(runs)) for key, runs in self._runs.items()
        }
        return {key: (failed, runs) for key, (failed, runs) in counts.items() if 0 < failed < runs}

    def seconds(self, jobs):
        """Gives key -> expected wall time [s] of jobs: the last, else the table's."""
        expected = {}
        for job in jobs:
            default = SECONDS.get(job.key, STAGE_SECONDS[job.stage])
            runs = self._runs.get(job.key)
            expected[job.key] = runs[-1]["seconds"] if runs else default
        return expected
