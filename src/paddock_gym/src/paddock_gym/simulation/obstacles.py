"""Objects on a track: boxes that stand, bots that move along the lane."""

from bullet_sim.pose import Pose

from paddock_gym.course import TrackObject
from paddock_gym.simulation.recipe import Spawn

COUNT = 3
CLEAR = 1.5  # between the car's start and the first object [m]
BOT_SPEEDS = (0.5, 1.0)  # [m/s]
BOX, BOT = (0.20, 0.20, 0.20), (0.30, 0.19, 0.12)  # length, width, height [m]
_SDF = """<sdf version="1.6"><model name="{name}"><static>true</static><link name="link">
<collision name="c"><geometry><box><size>{x} {y} {z}</size></box></geometry></collision>
<visual name="v"><geometry><box><size>{x} {y} {z}</size></box></geometry>
<material><ambient>{color} 1</ambient><diffuse>{color} 1</diffuse></material></visual>
</link></model></sdf>"""


class Obstacles:
    """Objects of one race.

    Args:
        course: Course of the lane.
        period: of an action [s].
        object_type: "boxes" or "bots".

    Attributes:
        objects: list of the current TrackObjects.
    """

    def __init__(self, course, period, object_type):
        self._course, self._period, self._type = course, period, object_type
        self._bots = object_type == "bots"
        self._size = BOT if self._bots else BOX
        self.objects = []

    def models(self):
        """Spawns of the objects, out of sight."""
        x, y, z = self._size
        color = "0.8 0.2 0.1" if self._bots else "0.75 0.55 0.3"
        text = _SDF.format(name=self._type, x=x, y=y, z=z, color=color)
        return [
            Spawn(f"{self._type}{index}", text, Pose((0.0, 0.0, -5.0 - index)))
            for index in range(COUNT)
        ]

    def start(self, world, rng, s):
        """Put the objects of a World at random arc lengths ahead of a car at arc length s [m]."""
        self._models = [world.model(f"{self._type}{index}") for index in range(COUNT)]
        room = (self._course.length - 2.0 * CLEAR) / COUNT
        self._courses = []
        for index in range(COUNT):
            at = s + CLEAR + (index + rng.uniform(0.2, 0.8)) * room
            side = rng.choice((-1.0, 1.0)) * rng.uniform(0.4, 0.55)
            speed = rng.uniform(*BOT_SPEEDS) if self._bots else 0.0
            self._courses.append([at, side, speed])
        self._show()

    def advance(self):
        """Advance the bots by one action."""
        if self._bots:
            for course in self._courses:
                course[0] += course[2] * self._period
            self._show()

    def _show(self):
        length, self.objects = self._course.length, []
        for model, (at, side, speed) in zip(self._models, self._courses):
            s = at % length if self._course.closed else min(at, length)
            left, right = self._course.sides(s)
            lateral = side * float(left if side > 0.0 else right)
            x, y, yaw = self._course.pose(s, lateral)
            model.set_state(Pose.from_xyz_rpy((x, y, self._size[2] / 2.0), (0.0, 0.0, yaw)))
            self.objects.append(TrackObject(x, y, yaw, s, lateral, speed))
