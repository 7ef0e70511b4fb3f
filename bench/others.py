"""Steps a second of Paddock's environments beside those of other simulators of cars.

    ./run exec python bench/others.py --mujoco PYTHON --racecar PYTHON --f1tenth PYTHON

The others are not part of Paddock: each runs with the Python of a virtual environment in which it
is installed; without one a line says how to install it. Rounds alternate, Paddock's single car
before each of the others, so that a slower minute slows both. Cars drive round a circle. The
section `peers` of ./run bench measures the same and keeps it.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from figures import BenchError, Spread  # noqa: E402
from pairs import Round, alternate, matched, pairs_of  # noqa: E402
from usage import Monitor  # noqa: E402

WORKER = pathlib.Path(__file__).resolve().parent / "observers" / "others.py"
REFERENCE = "paddock_state_1"
OURS = "6 driven joints, 4 wheels in contact, ODE's quickstep of 100 iterations, 1 ms"
MUJOCO = "6 driven joints, 4 wheels in contact, Newton's method, soft contacts, 1 ms; rollout"
RACECAR = "16 joints with 2 differentials, Bullet's contacts of 50 iterations, 10 ms"
# Name -> (which Python, what it simulates and returns).
SUBJECTS = {
    REFERENCE: ("paddock", f"state; {OURS}"),
    "paddock_state_16": ("paddock", "the same for 16 cars, each in its world (make_vec)"),
    "paddock_lidar_1": ("paddock", f"64 rays at 15 Hz; {OURS}"),
    "paddock_lidar_16": ("paddock", "the same for 16 cars, each in its world (make_vec)"),
    "mujoco_1": ("mujoco", f"state; {MUJOCO}"),
    "mujoco_16": ("mujoco", "the same for 16 cars, each in its world"),
    "racecar_1": ("racecar", f"1080 rays at 25 Hz, pose, motion; {RACECAR}"),
    "racecar_16": ("racecar", "the same for 16 cars in one world"),
    "f1tenth_1": ("f1tenth", "1080 rays at 100 Hz; single-track model in 2D, no contacts, 10 ms"),
    "f1tenth_16": ("f1tenth", "the same for 16 agents that also see and hit each other"),
    "car_racing": ("box2d", "96x96 colour image at 50 Hz; Box2D in 2D, 20 ms"),
}
# Pairs of subjects that observe alike.
BESIDE = (
    ("paddock_state_1", "mujoco_1"),
    ("paddock_state_16", "mujoco_16"),
    ("paddock_lidar_1", "racecar_1"),
    ("paddock_lidar_16", "racecar_16"),
    ("paddock_lidar_1", "f1tenth_1"),
    ("paddock_lidar_16", "f1tenth_16"),
)
INSTALL = {
    "mujoco": "python3 -m venv V && V/bin/pip install mujoco, then --mujoco V/bin/python",
    "racecar": "python3.10 -m venv V && git clone https://github.com/axelbr/racecar_gym && "
    "V/bin/pip install -e racecar_gym (Python 3.8 to 3.10), then --racecar V/bin/python",
    "f1tenth": 'python3 -m venv V && V/bin/pip install "f1tenth_gym @ '
    'git+https://github.com/f1tenth/f1tenth_gym@v1.0.0", then --f1tenth V/bin/python',
    "box2d": "python3 -m venv V && V/bin/pip install swig && PATH=$PWD/V/bin:$PATH V/bin/pip "
    'install "gymnasium[box2d]>=1.0", then --box2d V/bin/python',
}
NEEDED = {
    "mujoco": "mujoco.rollout",
    "racecar": "racecar_gym.envs.gym_api",
    "f1tenth": "f1tenth_gym",
    "box2d": "gymnasium.envs.box2d.car_racing, Box2D, pygame",
}
SECONDS = 1.0  # of a round


class Subject:
    """An environment in a process of its own that steps when asked.

    Args:
        python: interpreter with it.

    Attributes:
        period: simulated time of a step [s]; time_step: of the physics [s]; cars: in a step.
        pid: of the process.

    Raises:
        BenchError: the process did not start.
    """

    def __init__(self, python, name):
        self.name = name
        ours = SUBJECTS[name][0] == "paddock"
        self._process = subprocess.Popen(
            [python, *([] if ours else ["-I"]), str(WORKER), name], text=True,
            env=None if ours else quiet(), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        self.pid = self._process.pid
        about = self._answer()
        self.period, self.time_step, self.cars = (
            about[key] for key in ("period", "time_step", "cars")
        )

    def rate(self):
        """Round of steps a second; with several cars a step moves each of them.

        Its details have `own`: steps a second of processor time.
        """
        try:
            self._process.stdin.write(f"{SECONDS}\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # the answer is missing, too
        answer = self._answer()
        return Round(answer["rate"], {"own": answer["own"]})

    def _answer(self):
        line = self._process.stdout.readline()
        try:
            return json.loads(line)
        except ValueError:
            raise BenchError(
                f"{self.name}: its process ended or answered {line!r}; see above"
            ) from None

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


def missing(kind, python):
    """Why a simulator cannot run: a sentence with how to install it; empty where it can."""
    how = f"{kind} is not measured: install it with: {INSTALL[kind]}"
    if not python:
        return how
    if not os.access(python, os.X_OK):
        return f"--{kind} is {python!r}, which is no Python that can be run; {how}"
    test = [python, "-c", f"import {NEEDED[kind]}"]
    if subprocess.run(test, capture_output=True, env=quiet()).returncode:
        return f"{python} cannot import {NEEDED[kind]}; {how}"
    return ""


def quiet():
    """The environment without what would lead another Python to Paddock's packages."""
    return {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}


def measure(pythons, quick):
    """Measure all subjects whose Python is there.

    Args:
        pythons: kind -> path.

    Returns:
        dict: name -> figures of Pairs with period, time_step, cars, real_time; own: car seconds a
        second of processor time, a value a round, reference_own: of the reference beside it.
    """
    subjects = {}
    try:
        for name, (kind, _) in SUBJECTS.items():
            if kind in pythons:
                subjects[name] = Subject(pythons[kind], name)
        others = {name: one.rate for name, one in subjects.items() if name != REFERENCE}
        monitor = Monitor({"bench": [os.getpid(), *(one.pid for one in subjects.values())]})
        measured = alternate(subjects[REFERENCE].rate, others, pairs_of(quick), monitor)
    finally:
        for subject in subjects.values():
            subject.close()
    found = {name: pairs.figures() for name, pairs in measured.items()}
    for name, figures in found.items():
        figures.update(about(subjects[name], figures["variant"]["median"]))
        for key, rounds, subject in (
            ("own", measured[name].variant, subjects[name]),
            ("reference_own", measured[name].reference, subjects[REFERENCE]),
        ):
            scale = subject.period * subject.cars
            figures[key] = [scale * one_round.details["own"] for one_round in rounds]
    return found


def about(subject, rate):
    """What a subject's step is, and how fast its simulated time goes at a rate."""
    return {
        "period": subject.period,
        "time_step": subject.time_step,
        "cars": subject.cars,
        "real_time": rate * subject.period,
    }


def lines(found):
    """Text of what measure() found, line by line.

    A step is of different length and content everywhere; car seconds a second (steps a second,
    times seconds a step, times cars) say the same of all.
    """
    reference = next(iter(found.values()))["reference"]
    spreads = {REFERENCE: Spread.read(reference)}
    spreads.update({name: Spread.read(figures["variant"]) for name, figures in found.items()})
    yield (
        f"{'':18}{'steps a second':>34}{'s a step':>10}{'physics':>10}{'car s a s':>11}"
        f"{'a core':>9}"
    )
    for name, spread in spreads.items():
        about = found.get(name) or found["paddock_lidar_1"]  # steps of both are equally long
        pace = spread.median * about["period"] * about["cars"]
        yield (
            f"{name:18}{spread.text('.0f'):>34}{about['period']:10.4f}{about['time_step']:10.4f}"
            f"{pace:11.1f}{own(found, name).median:9.1f}  {SUBJECTS[name][1]}"
        )
    for mine, its in BESIDE:
        if its in found:
            ratio = over(found, mine, its).text()
            yield f"{mine} over {its}, car seconds a second of processor time: {ratio}"


def own(found, name):
    """Spread of a subject's car seconds a second of processor time."""
    if name == REFERENCE:
        return Spread.of(value for each in found.values() for value in each["reference_own"])
    return Spread.of(found[name]["own"])


def over(found, mine, its):
    """Spread of the ratio of two subjects' car seconds a second of processor time, round by round,
    each over the reference's beside it."""
    one, other = (
        [1.0] * len(found[its]["own"])
        if name == REFERENCE
        else [a / b for a, b in matched(found[name]["own"], found[name]["reference_own"])]
        for name in (mine, its)
    )
    return Spread.of(a / b for a, b in matched(one, other))


def main(arguments=None):
    """Measure and tell; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="\n".join(f"{kind}: {how}" for kind, how in INSTALL.items()),
    )
    for kind, what in (
        ("mujoco", "MuJoCo"),
        ("racecar", "racecar_gym"),
        ("f1tenth", "f1tenth_gym v1.0.0"),
        ("box2d", "Gymnasium with Box2D"),
    ):
        parser.add_argument(f"--{kind}", metavar="PYTHON", help=f"interpreter with {what}")
    parser.add_argument("--quick", action="store_true", help="fewer rounds")
    parser.add_argument("--save", type=pathlib.Path, metavar="FILE", help="also write JSON here")
    chosen = parser.parse_args(arguments)
    pythons = {"paddock": sys.executable}
    for kind in INSTALL:
        python = getattr(chosen, kind)
        reason = missing(kind, python)
        if reason:
            print(f"others: {reason}", file=sys.stderr)
        else:
            pythons[kind] = python
    try:
        found = measure(pythons, chosen.quick)
    except BenchError as error:
        print(f"others: {error}", file=sys.stderr)
        return 1
    for line in lines(found):
        print(line)
    if chosen.save:
        chosen.save.write_text(json.dumps(found, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
