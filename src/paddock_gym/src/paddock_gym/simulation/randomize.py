"""Random changes from run to run."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from bullet_sim.models.changes import link_properties, set_link_properties
from bullet_sim.pose import Pose

from paddock_gym.errors import GymError

RANDOMIZABLE = ("start", "friction", "mass", "latency", "camera", "light", "colours")
FRICTION = (0.7, 1.3)  # factors of the tyres' coefficient
MASS = (0.85, 1.15)  # factors of the chassis' mass and inertia
LATENCY = (0.0, 0.04)  # from the observation to the command that follows from it [s]
START_SIDE = 0.25  # of the lane's width to each edge: largest offset at the start
START_HEADING = math.radians(15.0)
CAMERA_SHIFT, CAMERA_ROTATION = 0.005, math.radians(2.0)
LIGHT, CONTRAST = (0.7, 1.2), (0.8, 1.2)  # factors of brightness and contrast
COLOR_GAIN = (0.8, 1.2)  # factors of each of red, green and blue
FIRST_STARTS = 0.05  # fraction of the track between starts that are not random


def parse(properties: bool | str | Iterable[str]) -> tuple[str, ...]:
    """Parse the option `randomize`.

    Args:
        properties: names of RANDOMIZABLE, or a text of them, separated by commas, as that of
            ./run train --randomize; True or all: all of them; False, nothing or (): none.

    Raises:
        GymError: unknown name; a text has a name twice, or all or nothing with others.
    """
    if isinstance(properties, bool):
        properties = "all" if properties else "nothing"
    names = tuple(properties.split(",") if isinstance(properties, str) else properties)
    if {"all", "nothing"} & set(names):
        if len(names) > 1:
            raise GymError(f"randomize is {properties!r}; all and nothing stand alone")
        return RANDOMIZABLE if names == ("all",) else ()
    for name in names:
        if name not in RANDOMIZABLE:
            raise GymError(f"randomize has {name!r}; there are {', '.join(RANDOMIZABLE)}")
    if len(set(names)) < len(names):
        raise GymError(f"randomize is {properties!r}; it must have each name once")
    return names


class Randomizer:
    """Samples the properties that change from run to run of one car.

    Args:
        properties: of parse().

    Attributes:
        delay: physics steps from the observation to the command.
        change_image: function that changes an image (H, W, 3) uint8.
        jitter: Pose of the camera's mount.
    """

    def __init__(self, scene, car, properties):
        self._scene, self._car, self._properties = scene, car, properties
        model = car.model
        self._wheels = [  # link, coefficient
            (name, link.surface.friction)
            for name, link in model.rigid_parts.items()
            if "wheel" in name
        ]
        self._chassis = model.description.root
        self._mass = link_properties(model, self._chassis) if "mass" in properties else None
        self._round = 0
        self.delay, self.jitter = 0, Pose()
        self.change_image = lambda rgb: rgb

    def sample(self, rng):
        """Sample the next run's properties and apply them to the car.

        Returns:
            Start (x, y, yaw) [m], [rad].
        """
        properties = self._properties
        if "friction" in properties:
            factor = rng.uniform(*FRICTION)
            for link, friction in self._wheels:
                self._car.model.body.set_friction(link, factor * friction)
        if "mass" in properties:
            factor = rng.uniform(*MASS)
            mass, center, inertia, gravity = self._mass
            set_link_properties(
                self._car.model, self._chassis, factor * mass, center, factor * inertia, gravity
            )
        if "latency" in properties:
            self.delay = round(rng.uniform(*LATENCY) / self._scene.world.time_step)
        self._sample_image(rng)
        return self._start(rng)

    def _sample_image(self, rng):
        properties = self._properties
        if "camera" in properties:
            shift = rng.uniform(-CAMERA_SHIFT, CAMERA_SHIFT, 3)
            self.jitter = Pose.from_xyz_rpy(
                shift, rng.uniform(-CAMERA_ROTATION, CAMERA_ROTATION, 3)
            )
        if not properties & {"light", "colours"}:
            return
        light = rng.uniform(*LIGHT) if "light" in properties else 1.0
        contrast = rng.uniform(*CONTRAST) if "light" in properties else 1.0
        color_gains = rng.uniform(*COLOR_GAIN, 3) if "colours" in properties else np.ones(3)
        gain = (light * contrast * color_gains).astype(np.float32)
        offset = np.float32(128.0 * light * (1.0 - contrast))

        def change(rgb):
            return np.clip(rgb * gain + offset, 0.0, 255.0).astype(np.uint8)

        self.change_image = change

    def _start(self, rng):
        """A pose on the course: at random, or 5 % further with each run."""
        course = self._scene.course
        room = course.length if course.closed else 0.8 * course.length
        if "start" not in self._properties:
            self._round += 1
            return course.pose(room * ((self._round - 1) * FIRST_STARTS % 1.0))
        s = rng.uniform(0.0, room)
        return course.pose(
            s,
            rng.uniform(-START_SIDE, START_SIDE) * sum(course.sides(s)) / 2.0,
            rng.uniform(-START_HEADING, START_HEADING),
        )
