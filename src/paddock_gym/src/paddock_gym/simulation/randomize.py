"""What may be different from run to run."""

import math

import numpy as np
from bullet_sim.models.changes import link_properties, set_link_properties
from bullet_sim.pose import Pose

from paddock_gym.errors import GymError

KINDS = ("start", "friction", "mass", "latency", "camera", "light", "colours")
FRICTION = (0.7, 1.3)  # factors of the tyres' coefficient
MASS = (0.85, 1.15)  # factors of the chassis' mass and inertia
LATENCY = (0.0, 0.04)  # from the observation to the command that follows from it [s]
START_SIDE = 0.25  # of the lane's width to each edge: largest offset at the start
START_TURN = math.radians(15.0)
CAMERA_SHIFT, CAMERA_TURN = 0.005, math.radians(2.0)
LIGHT, CONTRAST = (0.7, 1.2), (0.8, 1.2)  # factors of brightness and contrast
COLOURS = (0.8, 1.2)  # factors of each of red, green and blue
FIRST_STARTS = 0.05  # share of the track from start to start where the start is not random


def parse(kinds):
    """Kinds of an option.

    Args:
        kinds: names of KINDS, True (all), False or () (none).

    Returns:
        frozenset.

    Raises:
        GymError: unknown name.
    """
    if isinstance(kinds, bool):
        return frozenset(KINDS if kinds else ())
    kinds = (kinds,) if isinstance(kinds, str) else tuple(kinds)
    for kind in kinds:
        if kind not in KINDS:
            raise GymError(f"randomize has {kind!r}; there are {', '.join(KINDS)}")
    return frozenset(kinds)


class Randomizer:
    """Draws what changes from run to run of one car.

    Args:
        scene: Scene.
        car: Car.
        kinds: of parse().

    Attributes:
        delay: physics steps from the observation to the command.
        picture: function that changes a picture (H, W, 3) uint8.
        jitter: Pose of the camera's mount.
    """

    def __init__(self, scene, car, kinds):
        self._scene, self._car, self._kinds = scene, car, kinds
        engine, model = scene.world.engine, car.model
        self._wheels = [
            (model.body, model.index(part)) for part in model.rigid_parts if "wheel" in part
        ]
        self._friction = [engine.friction(*wheel) for wheel in self._wheels]
        self._chassis = model.description.root
        self._mass = link_properties(model, self._chassis) if "mass" in kinds else None
        self._round = 0
        self.delay, self.jitter = 0, Pose()
        self.picture = lambda rgb: rgb

    def draw(self, rng):
        """Draw for the next run and apply it to the car.

        Returns:
            Start (x, y, yaw) [m], [rad].
        """
        kinds = self._kinds
        if "friction" in kinds:
            factor = rng.uniform(*FRICTION)
            for wheel, friction in zip(self._wheels, self._friction):
                self._scene.world.engine.set_friction(*wheel, factor * friction)
        if "mass" in kinds:
            factor = rng.uniform(*MASS)
            mass, centre, inertia = self._mass
            set_link_properties(
                self._car.model, self._chassis, factor * mass, centre, factor * inertia, True
            )
        if "latency" in kinds:
            self.delay = round(rng.uniform(*LATENCY) / self._scene.world.time_step)
        self._draw_picture(rng)
        return self._start(rng)

    def _draw_picture(self, rng):
        kinds = self._kinds
        if "camera" in kinds:
            shift = rng.uniform(-CAMERA_SHIFT, CAMERA_SHIFT, 3)
            self.jitter = Pose.from_xyz_rpy(shift, rng.uniform(-CAMERA_TURN, CAMERA_TURN, 3))
        if not kinds & {"light", "colours"}:
            return
        light = rng.uniform(*LIGHT) if "light" in kinds else 1.0
        contrast = rng.uniform(*CONTRAST) if "light" in kinds else 1.0
        colours = rng.uniform(*COLOURS, 3) if "colours" in kinds else np.ones(3)
        gain = (light * contrast * colours).astype(np.float32)
        offset = np.float32(128.0 * light * (1.0 - contrast))

        def change(rgb):
            return np.clip(rgb * gain + offset, 0.0, 255.0).astype(np.uint8)

        self.picture = change

    def _start(self, rng):
        """A pose on the course: at random, or 5 % further with each run."""
        projector = self._scene.projector
        room = projector.length if projector.closed else 0.8 * projector.length
        if "start" not in self._kinds:
            self._round += 1
            return projector.pose(room * ((self._round - 1) * FIRST_STARTS % 1.0))
        s = rng.uniform(0.0, room)
        return offset_pose(
            projector,
            s,
            rng.uniform(-START_SIDE, START_SIDE) * sum(projector.sides(s)) / 2.0,
            rng.uniform(-START_TURN, START_TURN),
        )


def offset_pose(projector, s, lateral=0.0, turn=0.0):
    """(x, y, yaw) at an arc length [m], beside the centreline [m] and turned [rad]."""
    x, y, yaw = projector.pose(s)
    return (
        x - float(lateral) * math.sin(yaw),
        y + float(lateral) * math.cos(yaw),
        yaw + float(turn),
    )
