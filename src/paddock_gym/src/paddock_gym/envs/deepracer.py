"""Paddock/DeepRacer-v1: one car on one track, a setting of Paddock/Robot-v0."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from paddock_common.settings import Number
from track_model.track import load_track

from paddock_gym.contract.actions import Actions
from paddock_gym.envs import options as gym_options
from paddock_gym.envs.robot import RobotEnv
from paddock_gym.envs.run import Run
from paddock_gym.errors import GymError
from paddock_gym.simulation.car import recipe

TIME_STEP = 0.001  # physics step, that of track_model's worlds [s]
STEPS = Number(min=0.0001, max=0.005, unit="s")
CONTROL_RATE = Number(min=1.0, max=100.0, unit="Hz")


class DeepRacerEnv(RobotEnv):
    """A DeepRacer that learns to drive.

    Args:
        track: default, easy, medium, hard, or the path of a YAML, .npy or .csv file.
        observation: state, lidar or camera, or a tuple of them (a dict of arrays).
        action: continuous, or a model_metadata.json (its path, or its content as a dict).
        reward: progress, or the path of a reward_function.py.
        race: time_trial, object_avoidance or head_to_bot.
        randomize: some of start, friction, mass, latency, camera, light, colours; True: all.
            Without start each run starts 5 % of the track further on, as in AWS DeepRacer.
        time_step: physics step [s].
        control_rate: actions per simulated second [Hz]; an action takes the steps between two
            multiples of its period.
        walls: True or False: with or without walls along the lane; None: as the track's file says.
        colour: color camera images instead of gray ones.
        render_mode: rgb_array, human, or None.

    Attributes:
        task: Run.

    Raises:
        GymError, TrackError: an option is wrong.
    """

    task: Run

    def __init__(
        self,
        track: str = "default",
        observation: str | Iterable[str] = "state",
        action: str | dict[str, Any] | Actions = "continuous",
        reward: str = "progress",
        race: str = "time_trial",
        randomize: bool | str | Iterable[str] = ("start",),
        time_step: float = TIME_STEP,
        control_rate: float = 15.0,
        walls: bool | None = None,
        colour: bool = False,
        render_mode: str | None = None,
    ) -> None:
        self.options = gym_options.parse(observation, action, reward, race, randomize, colour)
        STEPS.check("time_step", time_step, GymError)
        CONTROL_RATE.check("control_rate", control_rate, GymError)
        loaded = load_track(track, walls)
        super().__init__(
            recipe(loaded, time_step),
            observation=(),
            task=Run(loaded, self.options, 1.0 / control_rate),
            vary=self.options.randomize,
            control_rate=control_rate,
            robot="racecar",
            render_mode=render_mode,
        )

    def _place(self, options: dict[str, Any]) -> None:
        """Have the next run start at a fraction of the track, lateral [m], turn [rad].

        Raises:
            GymError: unknown key.
        """
        unknown = set(options) - {"start", "lateral", "turn"}
        if unknown:
            raise GymError(f"reset has {min(unknown)!r}; there are start, lateral and turn")
        course = self.task.course
        s = float(options.get("start", 0.0)) * course.length
        place = course.pose(s, options.get("lateral", 0.0), options.get("turn", 0.0))
        self.task.place = place if options else None
