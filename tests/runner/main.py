"""Command line of the test run: picks jobs, runs them side by side, prints one sum.

Started by `./run test`, which sets the environment. Each job is one process with a deadline, a log
file and JUnit files from which the results are counted. A runner that is missing, or that ran
nothing, is a failure and not a silence.
"""

import argparse
import math
import os
import signal
import sys
import time
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

from runner import report
from runner.history import History
from runner.job import RESULTS, ROOT, WAITS
from runner.jobs import all_jobs, selected
from runner.process import Runner
from runner.schedule import Schedule, cores, slack

# Wall time of a job that runs alone [s].
DEADLINES = {
    "unit": 400.0,
    "lint": 120.0,
    "ros": 300.0,
    "soak": 600.0,
    "learning": 1200.0,
    "desk": 900.0,
    "tutorials": 1200.0,
    "long": 900.0,
}


def main():
    """Runs the selected jobs; exit status 0 only if something ran and nothing failed."""
    options = arguments()
    history = History()
    try:
        jobs = chosen(options, history)
    except LookupError as error:
        sys.exit(f"run test: {error}")
    if options.list:
        print("\n".join(f"{job.stage:5} {job.name}" for job in jobs))
        return
    if not jobs:
        print("run test: of the jobs that were run, none failed the last time")
        return
    paths = (str(ROOT / "tests"), os.environ.get("ROS_PACKAGE_PATH", ""))
    os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join(paths)
    RESULTS.mkdir(exist_ok=True)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's "&" has it ignored
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    begin = time.monotonic()
    schedule = Schedule(jobs, min(options.jobs, len(jobs)), history.seconds(jobs))
    factor = slack(schedule.slots, cores())
    outcomes = {}
    for job, outcome in run_all(schedule, Runner(), factor):
        outcomes[job] = outcome
        history.add(job.key, outcome)
        report.one(job, outcome, len(outcomes), len(jobs))
    flaky = {job.key: history.flaky()[job.key] for job in jobs if job.key in history.flaky()}
    report.whole(outcomes, flaky, time.monotonic() - begin)
    sys.exit(1 if any(outcome.failures for outcome in outcomes.values()) else 0)


def arguments():
    """Reads the command line."""
    parser = argparse.ArgumentParser(prog="./run test")
    parser.add_argument("filters", nargs="*", metavar="FILTER")
    parser.add_argument(
        "-j",
        "--jobs",
        type=count,
        default=cores(),
        metavar="N",
        help="how many jobs run side by side; by default as many as there are cores",
    )
    parser.add_argument("--failed", action="store_true", help="run what failed when it last ran")
    parser.add_argument("--list", action="store_true", help="only print the names")
    return parser.parse_intermixed_args()


def count(text):
    """Reads a number of jobs.

    Raises:
        argparse.ArgumentTypeError: It is no whole number above 0.
    """
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"N is {text!r}; it must be a whole number above 0")
    return int(text)


def chosen(options, history):
    """Gives the jobs that the command line asks for; empty only if none of them failed last.

    Raises:
        LookupError: A runner is not installed, or no job matches the filters.
    """
    everything = all_jobs()
    jobs = selected(everything, options.filters)
    if not jobs:
        names = ", ".join(job.name for job in everything)
        raise LookupError(
            f"nothing matches {' '.join(options.filters)!r}; there are the stages unit, lint, "
            f"ros, soak, learning, desk, tutorials, long, and the tests {names}"
        )
    if options.failed:
        failed = history.failed()
        jobs = [job for job in jobs if job.key in failed]
    return jobs


def run_all(schedule, runner, factor):
    """Runs a schedule's jobs side by side and gives (Job, Outcome) of each when it ends."""
    running = {}
    with ThreadPoolExecutor(math.ceil(schedule.slots / WAITS)) as pool:
        try:
            while True:
                while (job := schedule.take()) is not None:
                    deadline = factor * DEADLINES[job.stage]
                    running[pool.submit(runner.run, job, deadline)] = job
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    job = running.pop(future)
                    schedule.give_back(job)
                    yield job, future.result()
        except BaseException:
            runner.close()
            raise
