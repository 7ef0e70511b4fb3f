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
CAMERA_SHIFT, CAMERA_ROTATION = 0.005, math.radians(2.0)
LIGHT, CONTRAST = (0.7, 1.2), (0.8, 1.2)  # factors of brightness and contrast
COLOR_GAIN = (0.8, 1.2)  # factors of each of red, green and blue
VARIABLE = ("friction", "mass", "delay", "light", "colours", "noise")  # of any robot


def parse(
    properties: bool | str | Iterable[str],
    known: tuple[str, ...] = RANDOMIZABLE,
    option: str = "randomize",
) -> tuple[str, ...]:
    """Parse the option `randomize`, or another one of its kind.

    Args:
        properties: names of the known ones, or a text of them, separated by commas, as that of
            ./run train --randomize; True or all: all of them; False, nothing or (): none.

    Raises:
        GymError: unknown name; a text has a name twice, or all or nothing with others.
    """
    if isinstance(properties, bool):
        properties = "all" if properties else "nothing"
    names = tuple(properties.split(",") if isinstance(properties, str) else properties)
    if {"all", "nothing"} & set(names):
        if len(names) > 1:
            raise GymError(f"{option} is {properties!r}; all and nothing stand alone")
        return known if names == ("all",) else ()
    for name in names:
        if name not in known:
            raise GymError(f"{option} has {name!r}; there are {', '.join(known)}")
    if len(set(names)) < len(names):
        raise GymError(f"{option} is {properties!r}; it must have each name once")
    return names


class Variation:
    """Samples what changes from run to run of any model.

    Args:
        world: bullet_sim.world.World.
        model: whose friction (of its wheels, where links are called so) and mass vary.
        properties: names, as of parse().
        known: those that there are.

    Attributes:
        delay: physics steps from the observation to the command.
        jitter: Pose of a camera's mount.
        change_image: function that changes an image (H, W, 3) uint8.
    """

    def __init__(self, world, model, properties, known=VARIABLE):
        self._world, self._model = world, model
        self._properties = frozenset(parse(properties, known, "vary"))
        surfaces = {name: link.surface.friction for name, link in model.rigid_parts.items()}
        links = {name: 1.0 if given is None else given for name, given in surfaces.items()}
        wheels = {name: friction for name, friction in links.items() if "wheel" in name}
        self._wheels = wheels or links
        self._chassis = model.description.root
        self._mass = link_properties(model, self._chassis) if self.varies("mass") else None
        self.delay, self.jitter = 0, Pose()
        self.change_image = lambda rgb: rgb

    def varies(self, name):
        """Whether a property changes."""
        return name in self._properties

    def sample(self, rng):
        """Sample the next run's properties and apply them to the model."""
        if self.varies("friction"):
            factor = rng.uniform(*FRICTION)
            for link, friction in self._wheels.items():
                self._model.body.set_friction(link, factor * friction)
        if self.varies("mass"):
            factor = rng.uniform(*MASS)
            mass, center, inertia, gravity = self._mass
            set_link_properties(
                self._model, self._chassis, factor * mass, center, factor * inertia, gravity
            )
        if self._properties & {"latency", "delay"}:
            self.delay = round(rng.uniform(*LATENCY) / self._world.time_step)
        self._sample_image(rng)

    def _sample_image(self, rng):
        properties = self._properties
        if self.varies("camera"):
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
