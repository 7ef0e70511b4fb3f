"""One car's run: what it sees, does and gets, from start to end."""

import numpy as np
from gymnasium import spaces

from paddock_gym import observations
from paddock_gym.contract.actions import Continuous
from paddock_gym.contract.params import Waypoints, params
from paddock_gym.course import LAP, RUNNING, SEEN, Judge, seen
from paddock_gym.envs.rewards import progress
from paddock_gym.simulation.randomize import Randomizer
from paddock_gym.simulation.sensors import CarCamera, CarLidar

STANDING_STILL = (0.0, 0.0)  # speed, steering


def action_space(options):
    """Gymnasium space of the actions."""
    if isinstance(options.actions, Continuous):
        return spaces.Box(-1.0, 1.0, (2,), np.float32)
    return spaces.Discrete(len(options.actions.rows))


def observation_space(options):
    """Gymnasium space of the observations."""
    count = observations.STATE_SHAPE[0] + (2 * SEEN if options.objects else 0)
    shape = observations.COLOUR_SHAPE if options.colour else observations.GREY_SHAPE
    boxes = {
        "state": spaces.Box(-observations.LIMIT, observations.LIMIT, (count,), np.float32),
        "lidar": spaces.Box(0.0, 1.0, observations.RANGES_SHAPE, np.float32),
        "camera": spaces.Box(0, 255, shape, np.uint8),
    }
    if options.alone:
        return boxes[options.observations[0]]
    return spaces.Dict({name: boxes[name] for name in options.observations})


class Run:
    """One car's runs.

    Args:
        scene: Scene.
        car: one of its Cars.
        options: Options.
        obstacles: Obstacles, or None.

    Attributes:
        standing: Standing after the last action.
        motion: Motion then.
        delay: physics steps after which apply() is due.
        camera: CarCamera, or None.
    """

    def __init__(self, scene, car, options, obstacles=None):
        self._scene, self._car, self._options = scene, car, options
        self._obstacles = obstacles
        self._projector = scene.projector
        self._judge = Judge(scene.projector)
        self._observer = observations.StateObserver(scene.projector)
        self._waypoints = options.reward and Waypoints(scene.track, scene.projector)
        self._randomizer = Randomizer(scene, car, options.randomize)
        self._may_crash = scene.has_walls or obstacles is not None
        names = options.observations
        self._lidar = CarLidar(scene.world, car) if "lidar" in names else None
        self.camera = CarCamera(scene.painter, car) if "camera" in names else None
        self._observers = {"state": self._state, "lidar": self._ranges, "camera": self._picture}

    def begin(self, rng, start=None):
        """Start a run.

        Args:
            rng: numpy.random.Generator, also of the noise until the next start.
            start: (x, y, yaw) [m], [rad]; None: as the options say.

        Returns:
            observation, info.
        """
        self._rng = rng
        drawn = self._randomizer.draw(rng)
        self.delay = self._randomizer.delay
        self._car.place(*(drawn if start is None else start))
        self.motion = self._car.motion()
        self.standing = self._judge.start(self.motion)
        if self._obstacles:
            self._obstacles.start(rng, self.standing.s)
        self._command = STANDING_STILL
        return self._observe(), self._info()

    def decide(self, action):
        """Take an action; apply() makes the car follow it."""
        self._command = self._options.actions.command(action)

    def apply(self):
        """Command the car."""
        self._car.drive(*self._command)

    def end_step(self):
        """Look at what the last action led to.

        Returns:
            observation, reward, terminated, truncated, info.
        """
        if self._obstacles:
            self._obstacles.advance()
        self.motion = self._car.motion()
        crashed = self._may_crash and self._car.touched(self._scene.ground)
        standing = self.standing = self._judge.update(self.motion, crashed)
        reward = self._reward(standing)
        # A whole lap is no state in which nothing more is to be had: it truncates.
        lap = standing.end == LAP
        return self._observe(), reward, standing.end != RUNNING and not lap, lap, self._info()

    def params(self):
        """Params of a reward function after the last action."""
        self._waypoints = self._waypoints or Waypoints(self._scene.track, self._projector)
        standing = self.standing
        width = standing.left + standing.right
        return params(standing, self.motion, self._command, self._waypoints, width, self.objects)

    @property
    def objects(self):
        """Placed objects on the track now."""
        return self._obstacles.placed if self._obstacles else ()

    def _reward(self, standing):
        if self._options.reward is None:
            return progress(standing)
        return self._options.reward.reward(self.params())

    def _info(self):
        standing = self.standing
        return {
            "end": standing.end,
            "progress": standing.progress,
            "time": standing.steps * self._scene.period,
            "lateral": standing.lateral,
            "x": self.motion.x,
            "y": self.motion.y,
        }

    def _observe(self):
        names = self._options.observations
        if self._options.alone:
            return self._observers[names[0]]()
        return {name: self._observers[name]() for name in names}

    def _state(self):
        standing = self.standing
        row = self._observer.observe(self.motion, standing, self._command)
        if self._obstacles is None:
            return row
        return np.concatenate((row, seen(self._obstacles.placed, standing.s, self._projector)))

    def _ranges(self):
        return observations.ranges(self._lidar.scan(self._rng))

    def _picture(self):
        rgb = self._randomizer.picture(self.camera.picture(self._randomizer.jitter))
        return observations.picture(rgb, self._options.colour)


def advance(scene, runs):
    """Advance by one action; each run's command begins after its delay."""
    done = 0
    for run in sorted(runs, key=lambda run: run.delay):
        if run.delay > done:
            scene.advance(min(run.delay, scene.substeps) - done)
            done = min(run.delay, scene.substeps)
        run.apply()
    if done < scene.substeps:
        scene.advance(scene.substeps - done)
