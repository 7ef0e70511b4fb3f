"""What moves actors instead of their scripts: ActorPlugin's targets, social forces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bullet_sim.models.actor import FRAME
from bullet_sim.parts.base import Part, part_of
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, number, reading, vector
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import Array, Pose, Vec3, quaternion_from_yaw, rpy_from_quaternion
from bullet_sim.sensors.visible import triangles_of
from bullet_sim.xml_reader import floats

FACTOR = 4.5  # animation_factor where none is given, at which steps are as long as the way
HIPS = 1.2138  # [m] height at which the plugins hold an actor


def _models(xml: PluginXml, tag: str) -> tuple[str, ...]:
    """Names in the <model>s of an element."""
    return tuple((model.text or "").strip() for model in xml.element.findall(f"{tag}/model"))


def _ignored(xml: PluginXml) -> tuple[str, ...]:
    return _models(xml, "ignore_obstacles")


def _group(xml: PluginXml) -> tuple[str, ...] | None:
    return None if xml.element.find("group") is None else _models(xml, "group")


def _goals(xml: PluginXml) -> tuple[tuple[float, float], ...]:
    """The first two numbers of each <waypoint> that has them."""
    texts = [element.text or "" for element in xml.element.findall("trajectory/waypoint")]
    points = [floats(text, None, f"{xml.label} <waypoint>") for text in texts]
    return tuple((point[0], point[1]) for point in points if len(point) > 1)


@model_plugin("ActorPlugin")
@dataclass(frozen=True)
class WalkerSpec(PluginSpec):
    """Gazebo's ActorPlugin: walks to a target, then to one by chance, around models.

    Attributes:
        target: the first one (3,) [m], in the world.
        weight, obstacle_weight: of the way to the target and away from models.
        ignored: models that it does not go around.
        steps: how fast its limbs move for the way that it walks; 1: as far.
    """

    NAME = "actor"
    target: Vec3 = vector("target", (0.0, -5.0, HIPS))
    weight: float = number("target_weight", 1.15)
    obstacle_weight: float = number("obstacle_weight", 1.5)
    ignored: tuple[str, ...] = reading(_ignored, ())
    steps: float = number("animation_factor", FACTOR, lambda factor: factor / FACTOR)
    topic: str = ""


@model_plugin("PedestrianSFMPlugin")
@dataclass(frozen=True)
class PedestrianSpec(PluginSpec):
    """libPedestrianSFMPlugin: walks from goal to goal, by social forces (lightsfm).

    Attributes:
        goals: (x, y) [m] in the world; cyclic: from the last one it goes to the first.
        speed: at most [m/s].
        radius: of a person [m].
        desired, obstacle, social, gaze, coherence, repulsion: factors of the forces.
        distance: within which other actors count [m].
        group: names of the actors that it walks with; None: it has no group.
        ignored: models that are no obstacles.
        steps: see WalkerSpec.
    """

    NAME = "pedestrian"
    goals: tuple[tuple[float, float], ...] = reading(_goals, ())
    cyclic: bool = reading(lambda xml: xml.flag("trajectory/cyclic"), False)
    speed: float = number("velocity", 0.8)
    radius: float = number("radius", 0.35)
    desired: float = number("goal_weight", 2.0)
    obstacle: float = number("obstacle_weight", 10.0)
    social: float = number("social_weight", 2.1)
    gaze: float = number("group_gaze_weight", 3.0)
    coherence: float = number("group_coh_weight", 2.0)
    repulsion: float = number("group_rep_weight", 1.0)
    distance: float = number("people_distance", 5.0)
    group: tuple[str, ...] | None = reading(_group, None)
    ignored: tuple[str, ...] = reading(_ignored, ())
    steps: float = number("animation_factor", FACTOR, lambda factor: factor / FACTOR)
    topic: str = ""


SIDE = 1.5707  # [rad] that the yaw of an actor is left of its way
TEN_DEGREES = math.radians(10.0)


class ActorMover(Part):
    """Moves an actor, step by step.

    Between two updates, of as many steps as an actor's frame has, models are taken to stand still.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_place", "_way")

    def _rate(self) -> float:
        return 1.0 / FRAME if self.world.time_step < FRAME else 1.0 / self.world.time_step

    def prepare(self) -> None:
        """Show it where it is (simulation thread)."""
        self._show()

    def reset(self, time: float) -> None:
        """Go from where the file puts it."""
        motion = self.model.description.motion
        x, y, _ = motion.pose.position
        self._place = (x, y, rpy_from_quaternion(motion.pose.orientation)[2])
        self._way = 0.0
        super().reset(time)
        self._show()

    def _show(self) -> None:
        x, y, yaw = self._place
        pose = Pose((x, y, 0.0), quaternion_from_yaw(yaw - SIDE))
        body: Any = self.model.body  # an ActorBody
        body.walk_to(pose, self._way)

    def update(self, time: float, period: float) -> None:
        step = self.world.time_step
        self._look()
        for _ in range(max(1, round((time - self.updated) / step))):
            before = self._place
            self._walk(step)
            self._way += self.spec.steps * math.dist(self._place[:2], before[:2])
        self.updated = time
        self._show()

    def _look(self) -> None:
        """Find what is around it."""
        raise NotImplementedError

    def _walk(self, step: float) -> None:
        """Turn or go for a step [s]."""
        raise NotImplementedError


# Of Gazebo's ActorPlugin.
PACE = 0.8  # [m/s] times the weight of the target
ARRIVED, APART, ASIDE = 0.3, 2.0, 4.0  # [m] to targets, between targets and models, to obstacles
BOUNDS = ((-3.0, 3.5), (-10.0, 2.0))  # [m] of x and y, between which it stays
TURN = 0.001  # part of a turn on the spot in each step
TRIES = 1000  # targets by chance, after which it keeps the last one


@part_of(WalkerSpec)
class WalkerPlugin(ActorMover):
    """Walks an actor to targets: it turns on the spot, then goes, pushed away from models."""

    STATE = ("_target",)
    CACHE = ("_others",)

    def reset(self, time: float) -> None:
        """Go to the first target."""
        self._target: Vec3 = self.spec.target
        self._others: list[Vec3] = []
        super().reset(time)

    def _obstacles(self, ignored: tuple[str, ...]) -> list[Vec3]:
        """Positions of other models; those of actors at the height of its own."""
        return [
            (x, y, HIPS if model.description.motion is not None else z)
            for name, model in self.world.models.items()
            if name not in ignored
            for x, y, z in (model.pose.position,)
        ]

    def _look(self) -> None:
        self._others = self._obstacles((*self.spec.ignored, self.model.name))

    def _walk(self, step: float) -> None:
        x, y, yaw = self._place
        if math.dist(self._target, (x, y, HIPS)) < ARRIVED:
            self._choose()
        away = [goal - own for goal, own in zip(self._target, (x, y, HIPS))]
        factor = self.spec.weight / (math.hypot(*away) or 1.0)
        go_x, go_y = away[0] * factor, away[1] * factor
        for other in self._others:
            offset = [place - own for place, own in zip(other, (x, y, HIPS))]
            distance = math.hypot(*offset)
            if 0.0 < distance < ASIDE:
                push = self.spec.obstacle_weight / distance**2
                go_x, go_y = go_x - push * offset[0], go_y - push * offset[1]
        turn = math.remainder(math.atan2(go_y, go_x) + SIDE - yaw, 2.0 * math.pi)
        if abs(turn) > TEN_DEGREES:
            yaw += turn * TURN
        else:
            yaw, x, y = yaw + turn, x + go_x * PACE * step, y + go_y * PACE * step
        x, y = (min(max(value, low), high) for value, (low, high) in zip((x, y), BOUNDS))
        self._place = (x, y, math.remainder(yaw, 2.0 * math.pi))

    def _choose(self) -> None:
        """A target by chance, away from the last one and from all models."""
        x, y, _ = self._place
        models = [*self._obstacles((self.model.name,)), (x, y, HIPS)]
        for _ in range(TRIES):
            target = (*(float(self.rng.uniform(*bounds)) for bounds in BOUNDS), self._target[2])
            if all(math.dist(target, place) >= APART for place in (self._target, *models)):
                self._target = target  # type: ignore[assignment]
                return


# Of lightsfm.
SIGMA, LAMBDA, GAMMA, N, N_PRIME, RELAXATION = 0.2, 2.0, 0.35, 2.0, 3.0, 0.5
FAST_TURN = 0.005  # part of a turn on the spot in each step
Vector2 = Any  # array (2,)


@part_of(PedestrianSpec)
class PedestrianPlugin(ActorMover):
    """Walks an actor from goal to goal by the forces of lightsfm.

    As upstream other actors count with their places alone, an obstacle is where the line to the
    middle of the nearest model enters its box, and where there is none the origin is one.
    """

    STATE = ("_velocity", "_goals")
    CACHE = ("_obstacle", "_people", "_corners")

    def __init__(self, context: Any) -> None:
        self._corners: dict[int, list[tuple[str, Array]]] = {}  # of models' links, by the models
        super().__init__(context)

    def reset(self, time: float) -> None:
        """Go to the first goal, from rest."""
        self._goals = [np.array(goal) for goal in self.spec.goals]
        self._velocity = np.zeros(2)
        self._obstacle = np.zeros(2)
        self._people: list[tuple[Array, bool]] = []  # places, and whether they are of its group
        super().reset(time)

    def _box(self, model: Any) -> tuple[Array, Array] | None:
        """Lower and upper corner of the box around a model's collisions; None: it has none."""
        key = model.source.key
        if key not in self._corners:
            self._corners[key] = [
                (name, corners)
                for name, link in model.rigid_parts.items()
                for shape in link.collisions
                for corners in (_corners(shape),)
                if corners is not None
            ]
        points = [
            corners @ pose.matrix.T + pose.position
            for name, corners in self._corners[key]
            for pose in (model.link_state(name)[0],)
        ]
        if not points:
            return None
        every = np.concatenate(points)
        return every.min(axis=0), every.max(axis=0)

    def _look(self) -> None:
        x, y, _ = self._place
        own = np.array((x, y, HIPS))
        nearest, self._obstacle, self._people = math.inf, np.zeros(2), []
        for name, model in self.world.models.items():
            if model is self.model:
                continue
            place = np.array(model.pose.position)
            if model.description.motion is not None:
                if np.linalg.norm(place[:2] - own[:2]) < self.spec.distance:
                    self._people.append((place[:2], name in (self.spec.group or ())))
                continue
            box = None if name in self.spec.ignored else self._box(model)
            point = None if box is None else entry(own, place, *box)
            if point is not None and np.linalg.norm(point - own) < nearest:
                nearest, self._obstacle = float(np.linalg.norm(point - own)), point[:2]

    def _walk(self, step: float) -> None:
        x, y, yaw = self._place
        own, spec = np.array((x, y)), self.spec
        away = self._goals[0] - own if self._goals else np.zeros(2)
        heading = _unit(away) if np.linalg.norm(away) > ARRIVED else np.zeros(2)
        wanted = spec.desired * (heading * spec.speed - self._velocity)
        force = (wanted if heading.any() else -self._velocity) / RELAXATION
        offset = own - self._obstacle
        strength = math.exp(-(np.linalg.norm(offset) - spec.radius) / SIGMA)
        force = force + spec.obstacle * strength * _unit(offset)
        for place, _ in self._people:
            force = force + spec.social * social_force(place - own, self._velocity)
        force = force + self._group_force(own, heading)
        velocity = self._velocity + force * step
        speed = float(np.linalg.norm(velocity))
        self._velocity = velocity * min(1.0, spec.speed / speed) if speed > 0.0 else velocity
        x, y = (own + self._velocity * step).tolist()
        turn = math.remainder(
            math.atan2(self._velocity[1], self._velocity[0]) + SIDE - yaw, 2.0 * math.pi
        )
        yaw += turn * (FAST_TURN if abs(turn) > TEN_DEGREES else 1.0)
        self._place = (x, y, math.remainder(yaw, 2.0 * math.pi))
        if self._goals and math.dist(self._goals[0], (x, y)) <= ARRIVED:
            goal = self._goals.pop(0)
            self._goals += [goal] if spec.cyclic else []

    def _group_force(self, own: Vector2, heading: Vector2) -> Vector2:
        """Of the actors that it walks with."""
        spec = self.spec
        others = [place for place, is_of_group in self._people if is_of_group]
        if spec.group is None or not others:
            return np.zeros(2)
        middle = np.mean(others, axis=0) - own
        force, product = np.zeros(2), float(heading @ middle)
        if product < 0.0:  # they are behind: more than 90 degrees away
            force = spec.gaze * product / float(heading @ heading) * heading
        center = np.mean([own, *others], axis=0) - own
        soft = math.tanh(float(np.linalg.norm(center)) - len(others) / 2.0) + 1.0
        force = force + spec.coherence * soft / 2.0 * center
        for place in others:
            if np.linalg.norm(own - place) < 2.0 * spec.radius:
                force = force + spec.repulsion * (own - place)
        return force


def social_force(offset: Vector2, velocity: Vector2) -> Vector2:
    """Force (2,) by another person, for a factor of 1.

    Args:
        offset: (2,) [m] to it.
        velocity: (2,) [m/s] relative to it.
    """
    direction = _unit(offset)
    interaction = LAMBDA * velocity + direction
    length = float(np.linalg.norm(interaction))
    if length == 0.0:
        return np.zeros(2)
    along = interaction / length
    theta = math.remainder(
        math.atan2(direction[1], direction[0]) - math.atan2(along[1], along[0]), 2.0 * math.pi
    )
    reach, distance = GAMMA * length, float(np.linalg.norm(offset))
    slowing = math.exp(-distance / reach - (N_PRIME * reach * theta) ** 2)
    turning = np.sign(theta) * math.exp(-distance / reach - (N * reach * theta) ** 2)
    return -slowing * along - turning * np.array((-along[1], along[0]))


def entry(start: Array, end: Array, low: Array, high: Array) -> Array | None:
    """Point (3,) where the line from a start (3,) to an end (3,) enters a box; None: it does not,
    or starts within it."""
    way = end - start
    first, last = 0.0, 1.0
    for axis in range(3):
        if way[axis] == 0.0:
            if not low[axis] <= start[axis] <= high[axis]:
                return None
            continue
        sides = sorted(((side[axis] - start[axis]) / way[axis]) for side in (low, high))
        first, last = max(first, sides[0]), min(last, sides[1])
    return start + first * way if 0.0 < first <= last else None


def _unit(vector: Vector2) -> Vector2:
    length = np.linalg.norm(vector)
    return vector / length if length > 0.0 else vector


def _corners(shape: Any) -> Array | None:
    """Corners (8, 3) of the box around a collision in its link's frame; None: it is endless."""
    triangles = triangles_of(shape.geometry)
    if triangles is None:
        return None
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    grid = np.array(np.meshgrid(*zip(low, high))).reshape(3, -1).T
    return grid @ shape.pose.matrix.T + shape.pose.position
