"""DeepRacers that race each other on one track, as a ParallelEnv of PettingZoo."""

from __future__ import annotations

import numpy as np
from gymnasium import spaces
from track_model.track import Track, load_track

from paddock_gym import observations
from paddock_gym.course import LAP, progress
from paddock_gym.envs import options
from paddock_gym.envs.deepracer import TIME_STEP
from paddock_gym.envs.robots import RobotsEnv
from paddock_gym.envs.run import Run
from paddock_gym.envs.tasks import State
from paddock_gym.errors import GymError
from paddock_gym.simulation.car import recipe

GAP = 0.8  # between cars at the start, along the lane [m]
SIGHT = 4.0  # along the lane, to a car that is observed [m]
LEAD = 0.5  # of the reward for what is gained on the next car
LOST = "lost"  # end of a run: another car has made its lap


class Race(Run):
    """One car's race.

    The observation "state" is that of DeepRacer-v1, then of the nearest other car its distance
    ahead along the lane over 4 m (1 and -1: farther), its offset to the left over half the lane,
    its speed less the own one over 4 m/s. The reward is `progress`, and half of what is gained on
    that car along the lane [m].

    Args:
        track: Track.
        period: of an action [s].
        cars: all cars' tasks, to which this one is added.

    Attributes:
        over: whether its run has ended.
        actions: Continuous.
    """

    def __init__(self, track: Track, period: float, cars: list[Race]) -> None:
        parsed = options.parse("state", "continuous", "progress", "time_trial", ("start",), False)
        super().__init__(track, parsed, period)
        self._cars, self._number, self.over = cars, len(cars), False
        self.actions = parsed.actions
        self.feels = True
        cars.append(self)
        count = observations.STATE_SHAPE[0] + 3
        limit = observations.LIMIT
        self.spaces = {"state": spaces.Box(-limit, limit, (count,), np.float32)}

    def start(self, state: State, rng: np.random.Generator) -> None:
        """Put the car to its place of the grid; the first draws where that is, and the order."""
        course, count = self.course, len(self._cars)
        if self._number == 0:
            self.grid = float(rng.uniform(0.0, course.length)), rng.permutation(count)
        first, order = self._cars[0].grid
        s = (first + GAP * int(order[self._number])) % course.length
        side = rng.uniform(-0.25, 0.25) * sum(course.sides(s)) / 2.0
        self.place = course.pose(s, side, rng.uniform(-0.1, 0.1))
        self.over = False
        super().start(state, rng)

    def begun(self, state: State) -> None:
        super().begun(state)
        self._gap = self.rival()[0]

    def rival(self) -> tuple[float, float, float]:
        """Of the nearest other car: distance ahead along the lane [m], distance to the left of its
        centreline [m], forward speed [m/s]."""
        course, own = self.course, self.car.motion()
        here = course.locate(own.x, own.y)[0]
        found = []
        for car in self._cars:
            if car is not self:
                motion = car.car.motion()
                s, lateral = course.locate(motion.x, motion.y)
                found.append((course.difference(s, here), lateral, motion.forward))
        return min(found, key=lambda row: abs(row[0]))

    def reward(self, state: State) -> float:
        super().reward(state)
        before, self._gap = self._gap, self.rival()[0]
        gained = self.course.difference(before, self._gap)
        both = max(abs(before), abs(self._gap)) < SIGHT
        return float(progress(self.state) + (LEAD * gained if both else 0.0))

    def end(self, state: State) -> str:
        end = self.state.end
        if not end and any(car.state.end == LAP for car in self._cars if car.over):
            end = LOST
        self.over = bool(end)
        return end

    def _state(self) -> np.ndarray:
        ahead, lateral, speed = self.rival()
        half = sum(self.course.sides(self.state.s)) / 2.0
        gap = min(1.0, max(-1.0, ahead / SIGHT))
        extra = gap, lateral / half, (speed - self.motion.forward) / observations.SPEED_SCALE
        row = np.concatenate((super()._state(), extra), dtype=np.float32)
        return np.clip(row, -observations.LIMIT, observations.LIMIT)


class RaceEnv(RobotsEnv):
    """DeepRacers that start one behind the other, in random order, and race for a lap.

    Each has the actions of DeepRacer-v1. One whose run has ended stands where it is.

    Args:
        track: as of DeepRacer-v1; closed.
        cars: how many, 2 to 16.
        control_rate: actions per simulated second [Hz].
        max_steps: actions after which a race is truncated.

    Attributes:
        tasks: name -> Race.

    Raises:
        GymError, TrackError: an option is wrong.
    """

    def __init__(
        self,
        track: str = "default",
        cars: int = 2,
        control_rate: float = 15.0,
        max_steps: int = 600,
    ) -> None:
        if not 2 <= cars <= 16:
            raise GymError(f"cars is {cars!r}, must be from 2 to 16")
        loaded, tasks = load_track(track, None), []  # type: ignore[var-annotated]
        if not loaded.closed:
            raise GymError(f"track is {track!r}, which is open; a race needs a closed one")
        names = [f"car{number}" for number in range(1, cars + 1)]
        for _ in names:
            Race(loaded, 1.0 / control_rate, tasks)
        self.tasks = dict(zip(names, tasks))
        super().__init__(
            {name: {"task": task, "observation": ()} for name, task in self.tasks.items()},
            launch=recipe(loaded, TIME_STEP, names),
            vary=("start",),
            control_rate=control_rate,
            max_steps=max_steps,
        )
