"""Judges a run: progress, wheels beside the lane, stuck, wrong way, its end.

The rules are AWS DeepRacer's: a run ends when all four wheels are off the lane, after a crash,
after a whole lap, and when the car makes no progress or drives back.
"""

import math
from collections import deque
from dataclasses import dataclass

from track_model.referee.rules import Car

STUCK_STEPS = 15  # actions without progress
STUCK_WAY = 0.03  # progress within them that is none [m]
WRONG_WAY = 0.3  # way back that ends a run [m], as the referee's
LAP, OFF_TRACK, CRASHED, STUCK, REVERSED = "lap", "off_track", "crashed", "stuck", "reversed"
RUNNING = ""


@dataclass(slots=True)
class Standing:
    """Where a car is, and what became of its run.

    Attributes:
        s: arc length of base_link's projection [m].
        lateral: distance to the left of the centreline [m].
        heading: direction of the centreline there [rad].
        heading_error: the car's heading against it, -pi to pi [rad].
        left, right: from the centreline to the lane's edges there [m].
        wheels_off: of front left, front right, rear left, rear right: whether beside the lane.
        way: driven along the course since the start [m].
        gain: of it, since the last action [m].
        progress: share of the whole way [%].
        steps: actions so far.
        end: why the run ended, "" while it runs.
    """

    s: float
    lateral: float
    heading: float
    heading_error: float
    left: float
    right: float
    wheels_off: tuple
    way: float
    gain: float
    progress: float
    steps: int
    end: str

    @property
    def all_wheels_on(self):
        """Whether no wheel is beside the lane."""
        return not any(self.wheels_off)

    @property
    def off_track(self):
        """Whether all wheels are beside the lane."""
        return all(self.wheels_off)


class Judge:
    """Judges one car, action by action.

    Args:
        projector: track_model.referee.projector.Projector.
        car: track_model.referee.rules.Car.
    """

    def __init__(self, projector, car=Car()):
        self.projector = projector
        self._wheels = car.wheels  # from base_link

    def start(self, motion):
        """Start a run where the car is.

        Returns:
            Standing.
        """
        self._s = float(self.projector.project([(motion.x, motion.y)])[0][0])
        lateral = self.projector.place(motion.x, motion.y, self._s)[1]
        self._way = self._best = 0.0
        self._steps = 0
        length = self.projector.length
        self._goal = length if self.projector.closed else max(length - self._s, 1e-6)
        self._past = deque([0.0], maxlen=STUCK_STEPS + 1)
        return self._standing(motion, lateral, 0.0, False)

    def update(self, motion, crashed=False):
        """Judge after one more action.

        Args:
            motion: Motion now.
            crashed: whether the car touches an obstacle.

        Returns:
            Standing.
        """
        s, lateral = self.projector.place(motion.x, motion.y, self._s)
        gain = self.projector.course.difference(s, self._s)
        self._s = s
        self._way += gain
        self._best = max(self._best, self._way)
        self._past.append(self._best)
        self._steps += 1
        return self._standing(motion, lateral, gain, crashed)

    def _standing(self, motion, lateral, gain, crashed):
        heading = self.projector.heading(self._s)
        error = math.remainder(motion.yaw - heading, 2.0 * math.pi)
        wheels_off = self._wheels_off(lateral, error)
        left, right = self.projector.sides(self._s)
        return Standing(
            self._s,
            lateral,
            heading,
            error,
            float(left),
            float(right),
            wheels_off,
            self._way,
            gain,
            min(100.0, max(0.0, 100.0 * self._way / self._goal)),
            self._steps,
            self._end(all(wheels_off), crashed),
        )

    def _wheels_off(self, lateral, error):
        """Whether each wheel is beside the lane, which is an arc over the length of a car."""
        bend, projector = self.projector.bend(self._s), self.projector
        c, s = math.cos(error), math.sin(error)
        found = []
        for x, y in self._wheels:
            along, aside = c * x - s * y, lateral + s * x + c * y
            if abs(bend) > 1e-6:
                radius = math.hypot(bend * along, 1.0 - bend * aside)  # in those of the lane
                aside = (1.0 - radius) / bend
            left, right = projector.even_sides or projector.sides(self._s + along)
            found.append(not -right <= aside <= left)
        return tuple(found)

    def _end(self, off, crashed):
        if crashed:
            return CRASHED
        if off:
            return OFF_TRACK
        if self._way >= self._goal - (0.0 if self.projector.closed else 0.02):
            return LAP
        if self._best - self._way > WRONG_WAY:
            return REVERSED
        if len(self._past) > STUCK_STEPS and self._past[-1] - self._past[0] < STUCK_WAY:
            return STUCK
        return RUNNING
