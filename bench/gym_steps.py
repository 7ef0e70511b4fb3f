"""What the gym's car does with steps of 1, 2, 3 and 4 ms, as a table in Markdown.

    ./run exec python bench/gym_steps.py

Circles and a slalom in which the tires hold, and in which they slide; creep at rest; actions per
second of processor time, in alternating rounds. docs/learning.md has the table.
"""

import math
import statistics
import time

import gymnasium
import numpy as np

import paddock_gym

STEPS = (0.001, 0.002, 0.003, 0.004)  # [s]
HELD, SLIDING = (1.0, 0.13), (1.5, 0.5)  # circles: speed [m/s], steering [rad]
SLALOM = (1.0, 0.35, 30)  # [m/s], amplitude [rad], actions of a period
ROUNDS, ACTIONS = 7, 150


class Course:
    """The car on the default track's plane, with a physics step [s]."""

    def __init__(self, time_step):
        self.env = gymnasium.make(paddock_gym.IDS[0], time_step=time_step).unwrapped
        self._car, self._scene = self.env.scene.car, self.env.scene
        self.env.action_space.seed(0)

    def circle(self, speed, steering):
        """Radius [m] and speed [m/s] of a steady circle."""
        self._start()
        self._car.drive(speed, steering)
        self._wait(1.5)
        points, speeds = [], []
        for _ in range(60):
            self._scene.advance()
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
            self._scene.advance()
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

    def pace(self):
        """Actions per second of processor time, with the resets between."""
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

    def _wait(self, seconds):
        self._scene.advance(round(seconds / self._scene.world.time_step))


def main():
    """Print the table."""
    courses = [Course(step) for step in STEPS]
    paces = [[course.pace() for course in courses] for _ in range(ROUNDS)]
    print("| step | circle, held | circle, sliding | slalom | creep | actions per second |")
    print("| --- | --- | --- | --- | --- | --- |")
    first = None
    for course, pace in zip(courses, zip(*paces)):
        held, sliding = course.circle(*HELD), course.circle(*SLIDING)
        path = course.slalom(*SLALOM)
        first = first or (held, sliding, path)
        cells = [f"{1e3 * course.env.scene.world.time_step:.2f} ms"]
        for now, then in ((held, first[0]), (sliding, first[1])):
            changes = [100.0 * (new / old - 1.0) for new, old in zip(now, then)]
            cells.append(
                f"{now[0]:.3f} m, {now[1]:.3f} m/s ({changes[0]:+.2f}, {changes[1]:+.2f} %)"
            )
        way = np.hypot(*np.diff(first[2], axis=0).T).sum()
        off = np.hypot(*(path - first[2]).T).max()
        cells.append(f"{1e3 * off:.0f} mm of {way:.2f} m ({100.0 * off / way:.2f} %)")
        cells += [f"{course.creep():.1f} mm a minute", f"{statistics.median(pace):.0f}"]
        print(f"| {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
