"""Laps in the gym: drivers, films, results."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from deepracer_control.drivers.pursuit import Path, Pursuit
from paddock_common.films import FilmWriter
from track_model.referee.course import standing_start
from track_model.referee.referee import Car, Referee, Rules

from paddock_gym.course import LAP, RUNNING
from paddock_gym.ids import DEEPRACER
from paddock_gym.policy.onnx_policy import OnnxPolicy
from paddock_gym.simulation.car import GEOMETRY

FIRST_SEED = 10_000  # of the starts; training uses others
MAX_TIME, OPEN_START = 240.0, 0.5  # of ./run lap: of a lap [s]; Rules.standing_start [m]
MAX_OFFSET, MAX_HEADING = 0.15, math.radians(10.0)  # of a start [m], [rad]


@dataclass(frozen=True)
class Lap:
    """One start.

    Attributes:
        start: fraction of the track.
        end: why it ended: lap, off_track, crashed, stuck or reversed.
        progress: [%].
        time: simulated [s].
        trajectory: (N, 3) x, y [m], forward speed [m/s] after each action.
        rms_lateral, max_lateral: distance from the centreline [m].
    """

    start: float
    end: str
    progress: float
    time: float
    trajectory: np.ndarray
    rms_lateral: float
    max_lateral: float

    @property
    def is_lap(self):
        """Whether it was a full lap."""
        return self.end == LAP


def starts(count, seed=FIRST_SEED):
    """Starts for reset(options=...): count random poses, offset from the centreline and rotated."""
    rng = np.random.default_rng(seed)
    return [
        {
            "start": float(rng.uniform(0.0, 1.0)),
            "lateral": float(rng.uniform(-MAX_OFFSET, MAX_OFFSET)),
            "turn": float(rng.uniform(-MAX_HEADING, MAX_HEADING)),
        }
        for _ in range(count)
    ]


def drive(env, driver, start, seed=0, after_action=None) -> Lap:
    """Drive once.

    Args:
        driver: has act(observation, env) -> action, and restart().
        start: of starts().
        seed: of noise.
        after_action: called without arguments; for films.
    """
    observation, info = env.reset(seed=seed, options=start)
    driver.restart()
    trajectory, lateral, done = [], [], False
    while not done:
        observation, _, terminated, truncated, info = env.step(driver.act(observation, env))
        done = terminated or truncated
        motion = env.task.motion
        trajectory.append((motion.x, motion.y, motion.forward))
        lateral.append(info["lateral"])
        if after_action:
            after_action()
    return Lap(
        start["start"],
        info["end"],
        info["progress"],
        info["time"],
        np.array(trajectory),
        float(np.sqrt(np.mean(np.square(lateral)))),
        float(np.max(np.abs(lateral))),
    )


def line_to_line(env, driver, seed=FIRST_SEED):
    """Time of a lap as ./run lap measures it: by the referee, after its standing start.

    Args:
        driver: see drive().
        seed: of noise.

    Returns:
        [s]; None: no lap came of it.
    """
    course = env.task.course
    start = {"start": standing_start(course) / course.length}
    observation, info = env.reset(seed=seed, options=start)
    driver.restart()
    referee = Referee(course, rules=Rules(standing_start=OPEN_START))
    while info["end"] in (RUNNING, LAP) and info["time"] < MAX_TIME:  # the run's ends at its start
        motion = env.task.motion
        status, _ = referee.update(
            env.world.world.time, motion.x, motion.y, motion.yaw, motion.forward
        )
        if status.laps:
            return status.last_lap_time
        observation, *_, info = env.step(driver.act(observation, env))
    return None


def film_lap(env, driver, start, path, after_action=None) -> Lap:
    """Drive once and film it.

    Args:
        path: of the film.
        after_action: called without arguments.

    Raises:
        OSError: the file cannot be written.
    """
    rate = env.metadata["render_fps"]
    film = FilmWriter(path, rate)

    def add():
        image = env.observer_image()[..., ::-1].copy()
        state, motion = env.task.state, env.task.motion
        text = f"{state.progress:3.0f} %  {state.steps / rate:4.1f} s  {motion.forward:.2f} m/s"
        for color, width in (((0, 0, 0), 4), ((255, 255, 255), 1)):
            cv2.putText(
                image, text, (12, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.6, color, width, cv2.LINE_AA
            )
        film.add(image)
        if after_action:
            after_action()

    try:
        return drive(env, driver, start, after_action=add)
    finally:
        film.close()


REAR_AXLE = Car().rear  # x of the rear axle from base_link [m]


def follow(pursuit, motion, actions):
    """The action of Actions by which a car with this Motion follows the path of a Pursuit."""
    speed, curvature = pursuit.command(
        motion.x + REAR_AXLE * math.cos(motion.yaw),
        motion.y + REAR_AXLE * math.sin(motion.yaw),
        motion.yaw,
    )
    return actions.action(speed, math.atan(GEOMETRY.wheelbase * curvature))


class PolicyDriver:
    """A trained policy."""

    def __init__(self, path, env=DEEPRACER):
        self.policy = OnnxPolicy(path, env)

    def restart(self):
        """Nothing to clear."""

    def act(self, observation, _env):
        """The action for an observation."""
        return self.policy.act(observation)


class PursuitDriver:
    """Pure pursuit along the centreline, from the true pose: the driver of ./run lap.

    Args:
        max_speed: on straights [m/s].
        gains: lookahead [m], max_lateral_acceleration [m/s^2] of Pursuit.
    """

    def __init__(self, max_speed=1.0, **gains):
        self._gains, self._pursuit = dict(gains, max_speed=max_speed), None

    def restart(self):
        """Clear the position on the path."""
        self._pursuit = None

    def act(self, _observation, env):
        """The action at the car's pose."""
        if self._pursuit is None:
            track = env.task.track
            path = Path(track.centreline, closed=track.closed)
            self._pursuit = Pursuit(path, **self._gains)
        return follow(self._pursuit, env.task.motion, env.options.actions)


DRIVERS = {
    "pursuit": lambda: PursuitDriver(1.0),
    "fast_pursuit": lambda: PursuitDriver(2.0),
}
