"""A track with a car and obstacles, and its renderer."""

import dataclasses
import math
import os
import sys

from bullet_sim.errors import RenderError
from bullet_sim.pose import Pose
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.request import Quality
from bullet_sim.world import World
from paddock_common.settings import Number
from track_model.referee.course import Course
from track_model.track import load_track

from paddock_gym.course import TrackObject
from paddock_gym.errors import GymError
from paddock_gym.simulation import description
from paddock_gym.simulation.car import Car

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
        scene: Scene, before its first use.
        object_type: "boxes" or "bots".

    Attributes:
        objects: list of the current TrackObjects.
    """

    def __init__(self, scene, object_type):
        self._course, self._period = scene.course, scene.period
        self._bots = object_type == "bots"
        self._size = BOT if self._bots else BOX
        x, y, z = self._size
        color = "0.8 0.2 0.1" if self._bots else "0.75 0.55 0.3"
        self._models = [
            scene.world.spawn_sdf(
                f"{object_type}{index}",
                _SDF.format(name=object_type, x=x, y=y, z=z, color=color),
                Pose((0.0, 0.0, -5.0 - index)),
                str,
            )
            for index in range(COUNT)
        ]
        self.objects = []

    def start(self, rng, s):
        """Put the objects at random arc lengths ahead of a car at arc length s [m]."""
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


QUALITY = Quality(shadows="false", antialias="false")


class SceneRenderer:
    """Renders images of a world.

    Args:
        world: bullet_sim.world.World; models may be spawned later.

    Attributes:
        backend: "gl" or "tiny".
    """

    def __init__(self, world):
        self._world, self._count = world, 0
        # Mesa renders in the thread that asks it: an observation is too small for several
        os.environ.setdefault("LP_NUM_THREADS", "0")
        try:
            self._renderer, self.backend = GlRenderer(QUALITY), "gl"
        except RenderError:
            from bullet_sim.render.pybullet_renderer import PyBulletRenderer

            self._renderer, self.backend = PyBulletRenderer(), "tiny"

    def render(self, request, pose):
        """Render a camera's image of the world now.

        Args:
            request: CameraRequest; its pose is not used.
            pose: bullet_sim.pose.Pose of the camera in the link or world.

        Returns:
            (H, W, 3) uint8 RGB, top row first.
        """
        request_at = dataclasses.replace(request, pose=(pose.position, pose.rpy))
        return self.render_with_depth(request_at)[0]

    def render_with_depth(self, request):
        """As render(), from the request's pose; and its depths (H, W) float32 [m], or None."""
        if len(self._world.models) != self._count:
            self._count = len(self._world.models)
            self._renderer.sync_sources(self._world.sources(), self._world.scene)
        self._renderer.apply(self._world.snapshot())
        return self._renderer.render_with_depth(request, self._world.step_count)

    def close(self):
        """Free the renderer."""
        self._renderer.close()


SETTLING = 1.0  # simulated time until the cars are at rest [s]
TIME_STEP = 0.001  # physics step, that of track_model's worlds [s]
STEPS = Number(min=0.0001, max=0.005, unit="s")
CONTROL_RATE = Number(min=1.0, max=100.0, unit="Hz")
WINDOW = 0.5  # searched around the last arc length; one action moves a car less [m]


def make_world(**options):
    """An empty World of these options; tells on stderr where its solver is compiled before the
    first step."""
    world = World(**options)
    if not world.engine.is_compiled():
        text = "paddock: the solver is being compiled, once; it takes a minute or two"
        print(text, file=sys.stderr, flush=True)
    return world


class Scene:
    """A track with a car.

    Args:
        track: name or path of a track.
        time_step: physics step [s].
        control_rate: actions per simulated second [Hz].
        walls: see load_track.

    Attributes:
        course: Course of its lane.
        car: Car.
        substeps: physics steps of an action, in the mean and rounded.
        period: of control [s].

    Raises:
        GymError, TrackError: an option is wrong.
    """

    def __init__(self, track="default", time_step=TIME_STEP, control_rate=15.0, walls=None):
        STEPS.check("time_step", time_step, GymError)
        CONTROL_RATE.check("control_rate", control_rate, GymError)
        self.track = load_track(track, walls)
        self.course = Course(self.track.lane, WINDOW)
        self.period = 1.0 / control_rate
        self.substeps = max(1, round(self.period / time_step))
        self.world = make_world()
        self.world.load(description.world(time_step))
        ground = self.world.spawn_sdf("track", self.track.sdf(), Pose(), description.resolve)
        self.ground = frozenset({(ground.body.number, ground.link_in_body("ground")[0])})
        self.has_walls = "walls" in ground.link_names
        self.car = Car(self.world, "racecar", Pose(), description.car_urdf())
        self.world.engine.unlocked = True  # one thread alone has this world
        self.world.step(round(SETTLING / self.world.time_step))
        self.car.settled()
        self.world.step_count = self._actions = 0
        self._rested = self._renderer = None

    def restore(self):
        """Restore the state of the first start, bit-identical; set the car's pose after it."""
        if self._rested is None:
            self._rested = self.world.save_state()
        self.world.restore_state(self._rested)
        self._actions = 0

    def begin_action(self):
        """Physics steps of the next action: those up to the step that is closest to its end, since
        a control period need not be a multiple of a step; 67, 66 and 67 ms at 15 Hz."""
        self._actions += 1
        before, after = (
            math.floor(count * self.period / self.world.time_step + 0.5)
            for count in (self._actions - 1, self._actions)
        )
        return after - before

    def advance(self, substeps=None):
        """Advance by one action, or by some physics steps."""
        self.world.step(self.begin_action() if substeps is None else substeps)

    @property
    def renderer(self):
        """SceneRenderer of the world, made on first use."""
        if self._renderer is None:
            self._renderer = SceneRenderer(self.world)
        return self._renderer

    def close(self):
        """Free engine and renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
        self.world.close()
