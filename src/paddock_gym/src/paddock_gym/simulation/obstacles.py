"""Boxes that stand on the track, and bots that drive along it."""

import math

from bullet_sim.pose import Pose

from paddock_gym.course.objects import Placed

COUNT = 3
CLEAR = 1.5  # between the car's start and the first object [m]
BOT_SPEEDS = (0.5, 1.0)  # [m/s]
BOX, BOT = (0.20, 0.20, 0.20), (0.30, 0.19, 0.12)  # length, width, height [m]
_SDF = """<sdf version="1.6"><model name="{name}"><static>true</static><link name="link">
<collision name="c"><geometry><box><size>{x} {y} {z}</size></box></geometry></collision>
<visual name="v"><geometry><box><size>{x} {y} {z}</size></box></geometry>
<material><ambient>{colour} 1</ambient><diffuse>{colour} 1</diffuse></material></visual>
</link></model></sdf>"""


class Obstacles:
    """Objects of one race.

    Args:
        scene: Scene, before its first use.
        kind: "boxes" or "bots".

    Attributes:
        placed: list of Placed, as of now.
    """

    def __init__(self, scene, kind):
        self._projector, self._period = scene.projector, scene.period
        self._bots = kind == "bots"
        self._size = BOT if self._bots else BOX
        x, y, z = self._size
        colour = "0.8 0.2 0.1" if self._bots else "0.75 0.55 0.3"
        self._models = [
            scene.world.spawn_sdf(
                f"{kind}{number}",
                _SDF.format(name=kind, x=x, y=y, z=z, colour=colour),
                Pose((0.0, 0.0, -5.0 - number)),
                str,
            )
            for number in range(COUNT)
        ]
        self.placed = []

    def start(self, rng, s):
        """Place the objects at random, some way ahead of a car at arc length s [m]."""
        room = (self._projector.length - 2.0 * CLEAR) / COUNT
        self._courses = []
        for number in range(COUNT):
            at = s + CLEAR + (number + rng.uniform(0.2, 0.8)) * room
            side = rng.choice((-1.0, 1.0)) * rng.uniform(0.4, 0.55)
            speed = rng.uniform(*BOT_SPEEDS) if self._bots else 0.0
            self._courses.append([at, side, speed])
        self._show()

    def advance(self):
        """Move on by one action."""
        if self._bots:
            for course in self._courses:
                course[0] += course[2] * self._period
            self._show()

    def _show(self):
        length, self.placed = self._projector.length, []
        for model, (at, side, speed) in zip(self._models, self._courses):
            s = at % length if self._projector.closed else min(at, length)
            left, right = self._projector.sides(s)
            lateral = side * float(left if side > 0.0 else right)
            x, y, yaw = self._projector.pose(s)
            x, y = x - lateral * math.sin(yaw), y + lateral * math.cos(yaw)
            model.set_state(Pose.from_xyz_rpy((x, y, self._size[2] / 2.0), (0.0, 0.0, yaw)))
            self.placed.append(Placed(x, y, yaw, s, lateral, speed))
