"""What the gym's car does with physics steps of 0.5 to 4 ms, against 1 ms; no ROS.

Circles and a slalom in which the tires hold, and a circle in which they slide; creep at rest; a lap
by pure pursuit; actions a second of processor time, in alternating rounds.
"""

import math
import os
import statistics
import time

import numpy as np
from pairs import alternate, pairs_of
from report import Row, ratio_row
from usage import Monitor

FIRST, STEPS = 0.001, (0.0005, 0.001, 0.002, 0.003, 0.004)  # [s]
CIRCLES = {"holding": (1.0, 0.13), "sliding": (1.5, 0.5)}  # speed [m/s], steering [rad]
SLALOM = (1.0, 0.35, 30)  # [m/s], amplitude [rad], actions of a period
PURSUIT = 2.0  # of the lap [m/s]
ACTIONS = 150  # of a round


class Course:
    """The car on the default track's plane, with a physics step [s]."""

    def __init__(self, time_step):
        from paddock_gym.envs.deepracer import DeepRacerEnv

        self.env = DeepRacerEnv(time_step=time_step)
        self._car, self._world = self.env.task.car, self.env.world
        self.env.action_space.seed(0)

    def circle(self, speed, steering):
        """Radius [m] and speed [m/s] of a steady circle."""
        self._start()
        self._car.drive(speed, steering)
        self._wait(1.5)
        points, speeds = [], []
        for _ in range(60):
            self._act()
            motion = self._car.motion()
            points.append((motion.x, motion.y))
            speeds.append(math.hypot(motion.forward, motion.leftward))
        points = np.array(points)
        rows = np.c_[2.0 * points, np.ones(len(points))]
        x, y, rest = np.linalg.lstsq(rows, (points**2).sum(axis=1), rcond=None)[0]
        return math.sqrt(rest + x * x + y * y), statistics.mean(speeds)

    def slalom(self, speed, amplitude, period):
        """Positions (90, 2) [m], one after each action."""
        self._start()
        path = []
        for number in range(90):
            self._car.drive(speed, amplitude * math.sin(2.0 * math.pi * number / period))
            self._act()
            motion = self._car.motion()
            path.append((motion.x, motion.y))
        return np.array(path)

    def creep(self):
        """[mm] in a minute at rest."""
        self._start()
        self._wait(1.0)
        before = self._car.motion()
        self._wait(60.0)
        after = self._car.motion()
        return 1e3 * math.hypot(after.x - before.x, after.y - before.y)

    def lap(self):
        """Time [s] from line to line; None: no lap came of it."""
        from paddock_gym.evaluation.laps import PursuitDriver, line_to_line

        return line_to_line(self.env, PursuitDriver(PURSUIT))

    def pace(self):
        """Actions a second of processor time, with the resets between."""
        self.env.reset(seed=0)
        start = time.process_time()
        for _ in range(ACTIONS):
            steering, _ = self.env.action_space.sample()
            _, _, terminated, truncated, _ = self.env.step((0.3 * steering, -0.6))
            if terminated or truncated:
                self.env.reset()
        return ACTIONS / (time.process_time() - start)

    def _start(self):
        self.env.reset(seed=1, options={"start": 0.0})
        self._count = 0

    def _act(self):
        """Advance by one action."""
        from paddock_gym.envs.agent import steps_of

        self._count += 1
        self._world.advance(steps_of(self._count, self.env.period, self._world.world.time_step))

    def _wait(self, seconds):
        self._world.advance(round(seconds / self._world.world.time_step))


def measure(quick, log):
    """Paths, laps and paces of each step; quick: 1 and 4 ms."""
    courses = {step: Course(step) for step in ((FIRST, STEPS[-1]) if quick else STEPS)}
    found = {}
    for step, course in courses.items():
        found[label(step)] = {
            **{name: course.circle(*circle) for name, circle in CIRCLES.items()},
            "slalom": course.slalom(*SLALOM).tolist(),
            "creep": course.creep(),
            "lap": course.lap(),
        }
        print(f"gym_steps: {label(step)} is done", file=log, flush=True)
    others = {label(step): course.pace for step, course in courses.items() if step != FIRST}
    monitor = Monitor({"bench": [os.getpid()]})
    paces = alternate(courses[FIRST].pace, others, pairs_of(quick), monitor)
    for course in courses.values():
        course.env.close()
    return {"steps": found, "paces": {name: pace.figures() for name, pace in paces.items()}}


def label(step):
    """A step [s] in words."""
    return f"{1e3 * step:g} ms"


def rows(figures):
    """Of each step: what it does, and how far that is from 1 ms."""
    first = figures["steps"][label(FIRST)]
    way = float(np.hypot(*np.diff(np.array(first["slalom"]), axis=0).T).sum())
    for name, found in figures["steps"].items():
        for circle in CIRCLES:
            (radius, speed), (its_radius, its_speed) = found[circle], first[circle]
            yield value_row(f"{name}, circle, tires {circle}, radius", radius, its_radius, "m")
            yield value_row(f"{name}, circle, tires {circle}, speed", speed, its_speed, "m/s")
        gap = np.hypot(*(np.array(found["slalom"]) - first["slalom"]).T).max()
        text = f"at most {1e3 * gap:.1f} mm off in {way:.2f} m"
        yield Row(f"{name}, slalom", text, 100.0 * float(gap) / way, "% of the way off 1 ms")
        yield Row(f"{name}, creep", f"{found['creep']:.3f} mm", found["creep"], "mm a minute")
        if found["lap"] is None:
            yield Row(f"{name}, lap", "none")
        else:
            yield value_row(f"{name}, lap", found["lap"], first["lap"], "s")
    for name, pace in figures["paces"].items():
        yield ratio_row(f"{name}, pace", pace, label(FIRST), "actions per s of processor time")


def value_row(name, value, reference, unit):
    """The Row of a value with its distance from that of 1 ms."""
    far = f" ({100.0 * (value / reference - 1.0):+.2f} %)" if reference else ""
    return Row(name, f"{value:.4g} {unit}{far}", value, unit)
