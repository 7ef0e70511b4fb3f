"""The engine whose bodies move as in Gazebo: steps as Gazebo's ODE makes them.

What moves is numbers in arrays (see quickstep/ and arrays.py). A mirror of PyBullet's, made when it
is needed, finds the contacts of shapes that quickstep does not know, such as meshes that cannot be
read.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.description.collisions import self_colliding, without_overlapping_hulls
from bullet_sim.description.lump import LumpedModel, as_printed, lump
from bullet_sim.description.model import EVERYTHING, Joint, ModelDescription
from bullet_sim.description.world import OdeSettings
from bullet_sim.engine.api import WORLD, Body, BodyLink, EngineState, Rays
from bullet_sim.engine.efforts import MAX_RECORDED, EffortRow
from bullet_sim.engine.ode.arrays import ArrayBuilder, Attachment, Contents
from bullet_sim.engine.ode.body import OdeBody
from bullet_sim.engine.ode.contacts import Contacts
from bullet_sim.engine.ode.rays import MeshScene, RayScene, RayShape
from bullet_sim.engine.ode.records import Records
from bullet_sim.engine.ode.shapes import ShapeCache
from bullet_sim.engine.ode.tables import Tree, make_tree
from bullet_sim.engine.ode.threads import Helpers, processors
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.library import advance, compile_once, is_compiled
from bullet_sim.errors import ModelError
from bullet_sim.pose import Array, Pose, Vec3, vector3

if TYPE_CHECKING:
    from bullet_sim.engine.bullet.mirror import Mirror

NO_PYBULLET = (
    "PyBullet cannot be loaded ({}), and something in this world needs it: a shape or a ray that "
    "the solver 'ode' leaves to it; ./run setup installs it, or pip install pybullet"
)


class OdeEngine:
    """See api.Engine.

    Attributes:
        bodies: by their numbers; those of removed ones are given again.
        rows, joint_rows: of the bodies' links and joints, see quickstep/layout.py.
        joint_numbers: the latter as a flat memory view: a few numbers of it are read and written
            faster so, and without giving up Python's lock.
        arrays, contents: all that steps work with, and what it is built of.
        last_contacts: of the last step.
        records: see api.Records.
        is_built: the arrays have all that is there now.
        is_ahead: bodies are not where the mirror has them.
        unlocked: let other threads of Python run during steps: where each has a world of its own.
    """

    def __init__(self, time_step: float, gravity: Vec3, merges_fixed_joints: bool = False) -> None:
        self._merges = merges_fixed_joints
        self.time_step, self.gravity = float(time_step), vector3(gravity)
        self.unlocked, self.placements = False, 0
        self._helpers: Helpers | None = None
        self._numbers, self._gravity = np.zeros(q.S_SIZE), np.zeros(3)
        self.configure(OdeSettings())
        self._trees: dict[int, tuple[Array, Tree]] = {}  # of triangles, by their id
        self._shapes = ShapeCache(self)
        self.records = Records(self)
        self.clear()

    @cached_property
    def mirror(self) -> Mirror:
        """PyBullet's copies of the bodies; most worlds have none: a client alone takes 30 MB.

        Raises:
            ModelError: PyBullet is not installed.
        """
        try:
            from bullet_sim.engine.bullet.mirror import Mirror
        except ImportError as error:
            raise ModelError(NO_PYBULLET.format(error)) from error

        return Mirror(self)

    @property
    def has_mirror(self) -> bool:
        """Whether something has needed the mirror."""
        return "mirror" in vars(self)

    def _drop_mirror(self) -> None:
        """Go on without a mirror, whose contacts would start anew."""
        if self.has_mirror:
            self.mirror.close()
            del self.mirror

    # Settings -----------------------------------------------------------------------------------
    @property
    def solver_iterations(self) -> int:
        """See api.Engine."""
        return self.settings.iterations

    def configure(self, settings: OdeSettings) -> None:
        """Set what a world file says of the solver, before bodies are added."""
        self.settings = settings
        self._end_threads()
        numbers = self._numbers
        numbers[q.S_RELAXATION], numbers[q.S_ERP] = settings.relaxation, settings.erp
        numbers[q.S_CFM], numbers[q.S_RESCALE] = settings.cfm, float(settings.evens_inertias)
        numbers[q.S_MAX] = settings.max_speed

    def set_solver_iterations(self, count: int) -> None:
        """See api.Engine."""
        self.configure(replace(self.settings, iterations=int(count)))

    def set_gravity(self, gravity: Vec3) -> None:
        """See api.Engine."""
        self.gravity = vector3(gravity)
        self._wake_all()

    def set_time_step(self, time_step: float) -> None:
        """See api.Engine."""
        self.time_step = float(time_step)

    def is_compiled(self) -> bool:
        """Whether this version of the solver was compiled before, next to its source."""
        return is_compiled()

    def compile(self) -> None:
        """Compile the solver, unless that was done; else the first step does."""
        compile_once()
        self._advance(0, -1)
        self._ray_scene()[0].cast(Rays(np.zeros(3), np.zeros((0, 3)), 0.0, 0.0))

    def close(self) -> None:
        """See api.Engine."""
        self._end_threads()
        self._drop_mirror()

    def clear(self) -> None:
        """See api.Engine."""
        self._drop_mirror()
        self.bodies: dict[int, OdeBody] = {}
        self._free_numbers: list[int] = []  # of bodies that were removed; the last is next
        self.layout = 0
        self.is_ahead = self.is_built = False
        self._placed: set[OdeBody] = set()  # bodies whose rows are not where they were put
        self.contents = Contents()
        self.held: dict[OdeBody, Vec3] = {}  # see OdeBody.hold_velocity()
        self.last_contacts = Contacts(self)
        self._build_arrays()

    # Bodies -------------------------------------------------------------------------------------
    def lump(self, description: ModelDescription) -> LumpedModel:
        """See api.Engine."""
        lumped = lump(description, as_in_gazebo=True, is_rigid=self._merges)
        return as_printed(lumped) if description.is_urdf else lumped

    def add(self, model: LumpedModel, description: ModelDescription, pose: Pose) -> OdeBody:
        """See api.Engine."""
        number = self._free_numbers.pop() if self._free_numbers else len(self.bodies)
        self.bodies[number] = body = OdeBody(self, number, model, description, pose)
        self.note_layout("add", number, len(body.links))
        body.collisions = without_overlapping_hulls(
            self_colliding(description, model), description, model,
            lambda one, other: self.mirror.client.depth((number, one), (number, other)),
        )  # fmt: skip
        if self.has_mirror:
            self.mirror.remove(body)  # which did not know yet what collides
        if not body.is_static:
            self.contents.moving[number] = body
        if body.is_fixed:
            self.contents.immobile[number] = body
        self.placements += 1
        self.is_built = False
        self.note_placed(body)
        for name, link in model.links.items():
            if link.surface.bitmask != EVERYTHING:
                body.set_bitmask(name, link.surface.bitmask)
        return body

    def remove(self, body: Body) -> None:
        """See api.Engine."""
        number, contents = body.number, self.contents
        self._wake_all()
        self.is_built = False
        removed = self.bodies.pop(number)
        self._free_numbers.append(number)
        contents.moving.pop(number, None)
        contents.immobile.pop(number, None)
        self._placed.discard(removed)
        self.held.pop(removed, None)
        self.arrays.models.discard(number)  # another body may get its number
        for key in [k for k, a in contents.attached.items() if number in (a.parent[0], a.child[0])]:
            del contents.attached[key]
        contents.recorded = {link for link in contents.recorded if link[0] != number}
        for of_links in (contents.filtered, contents.friction):
            for link in [link for link in of_links if link[0] == number]:
                del of_links[link]
        if self.has_mirror:
            self.mirror.remove(removed)
        self.note_layout("remove", number)

    def note_layout(self, *event: object) -> None:
        """Note what gives another order to contacts."""
        self.layout = zlib.crc32(repr((self.layout, event)).encode())

    def note_placed(self, body: OdeBody) -> None:
        """A body has a placement: it is put there before the next step."""
        self._placed.add(body)
        self.is_ahead = True
        if self.has_mirror:
            self.mirror.note_placed(body)
        if body.is_fixed:  # what sleeps on it goes on sleeping, as in Gazebo
            self.is_built = False  # planes and boxes

    def _wake_all(self) -> None:
        for body in self.contents.moving.values():
            body.wake()

    # Arrays -------------------------------------------------------------------------------------
    def refresh(self) -> None:
        """Make the arrays tell what is there now, where it was put."""
        self.build()
        if self._placed:
            placed, self._placed = sorted(self._placed, key=lambda body: body.number), set()
            for body in placed:
                body.settle()

    def build(self) -> None:
        """Make the arrays of what is there now; states and what joints are told are kept."""
        if self.is_built:
            return
        moving, attached = self.contents.moving, self.contents.attached
        kept = {
            body: (body.rows.copy(), body.joint_rows.copy())
            for body in moving.values()
            if body.has_rows()
        }
        moved = {
            key: self.joint_rows[row, q.ANGLE : q.RATE + 1].copy()
            for key, row in self.arrays.attached.items()
            if key in attached and attached[key].joint is not None
        }
        self._build_arrays()
        for body, (rows, joint_rows) in kept.items():
            _copy_state(body, rows, joint_rows)
        for key, values in moved.items():
            if key in self.arrays.attached:
                self.joint_rows[self.arrays.attached[key], q.ANGLE : q.RATE + 1] = values
        self._sort()
        self.is_built = True

    def _build_arrays(self) -> None:
        self._end_threads()
        builder = ArrayBuilder(self, self._shapes, self.settings, self.contents)
        self.arrays = arrays = builder.build(self._numbers, self._gravity)
        self.rows, self.joint_rows = arrays.state.system.bodies, arrays.state.system.joints
        self.joint_numbers: Any = memoryview(self.joint_rows.reshape(-1))
        self.last_contacts.use(arrays)
        self.records.use(arrays)
        self._rays: tuple[RayScene, bool] | None = None
        self._sort()

    def _sort(self) -> None:
        """Bodies in the order of the last step."""
        self.arrays.state.sequence[:] = np.argsort(self.rows[:, q.PLACE], kind="stable")

    def _attached_rows(self) -> Array:
        """Rows of the joints of what is attached, which follow those of the models."""
        return self.joint_rows[sum(body.row_count for body in self.contents.moving.values()) :]

    # States -------------------------------------------------------------------------------------
    def save_state(self) -> EngineState:
        """See api.Engine."""
        self._drop_mirror()  # PyBullet's contacts start anew, as they do where this is restored
        self.refresh()
        moving = self.contents.moving
        data = {
            "poses": {n: body.base for n, body in self.bodies.items() if body.is_fixed},
            "bodies": {n: body.rows.copy() for n, body in moving.items()},
            "joints": {n: body.joint_rows.copy() for n, body in moving.items()},
            "applied": {n: [each.applied for each in body.motors] for n, body in moving.items()},
            "held": self._attached_rows().copy(),
            "sleepers": self.last_contacts.sleepers,
            "attached": dict(self.contents.attached),
        }
        return EngineState(self.layout, False, data)

    def restore_state(self, saved: EngineState) -> bool:
        """See api.Engine."""
        self._drop_mirror()
        state = saved.data
        for number, pose in state["poses"].items():
            if self.bodies[number].base != pose:
                self.bodies[number].set_pose(pose.position, pose.orientation)
        if state["attached"] != self.contents.attached:
            self.contents.attached, self.is_built = dict(state["attached"]), False
        self.refresh()
        for number, body in self.contents.moving.items():
            _copy_state(body, state["bodies"][number], state["joints"][number])
            body.rows[:, q.FORCE : q.FORCE + 6] = 0.0
            for motor, applied in zip(body.motors, state["applied"][number]):
                motor.applied = applied
        self._attached_rows()[:] = state["held"]
        self.held.clear()
        self._sort()
        self.last_contacts.restore(state["sleepers"])
        self.is_ahead = True
        return saved.layout == self.layout

    # Steps --------------------------------------------------------------------------------------
    def step(
        self, count: int = 1, efforts: Sequence[EffortRow] = (), records: bool = False
    ) -> Array | None:
        """See api.Engine."""
        self.refresh()
        if not efforts and not records:  # nothing is given to each step or taken from it
            self._make_steps(count)
            return None
        state = self.arrays.state
        for row, effort in zip(state.efforts, efforts):
            effort.numbers[q.PID_JOINT] = effort.motor.row  # type: ignore[attr-defined]
            row[:] = effort.numbers
        state.active[:] = len(efforts), records, 0
        self.records.note_acting(effort.motor for effort in efforts)
        try:
            self._make_steps(count)
        finally:
            state.active[:2] = 0
        for numbers, effort in zip(state.efforts[: len(efforts)].tolist(), efforts):
            effort.numbers = numbers
            effort.motor.applied = effort.applied
        recorded = state.recorded.reshape(MAX_RECORDED, 2, len(self.joint_rows))
        return recorded[:count] if records else None

    def _make_steps(self, left: int) -> None:
        if not len(self.rows):
            return
        self._gravity[:] = self.gravity
        state = self.arrays.state
        for row, (body, velocity) in zip(state.held, self.held.items()):
            row[:] = *body.row_numbers(), *velocity
        state.holding[:] = len(self.held), False
        self.held.clear()
        while left > 0:
            given = self.last_contacts.find() if self.arrays.always else -1
            done = self._advance(1 if given >= 0 else left, given)
            if not done:  # it needs contacts that the mirror finds
                done = self._advance(1, self.last_contacts.find())
            left -= done
            state.holding[1] = True
        state.holding[0] = 0
        self.is_ahead = True

    def measure_joints(self) -> None:
        """Have joints tell where a body has just been put that they hold."""
        self._advance(0, -1)
        self.is_ahead = True

    def joint_columns(self, body: Body, joints: Iterable[str]) -> list[int]:
        """See api.Engine."""
        self.build()
        own = self.bodies[body.number]
        return [own.order[own.joints.index(name)] for name in joints]

    def _advance(self, count: int, given: int) -> int:
        step, iterations = self.time_step, self.settings.iterations
        arrays, threads = self.arrays, self.settings.island_threads
        if threads > 1 and self._helpers is None and len(arrays.models) > 1:
            count_of_helpers = min(threads, processors()) - 1
            self._helpers = Helpers(self, arrays.state, arrays.table, count_of_helpers)
        numbers = count, given, step, iterations, arrays.watch, arrays.sleepy
        done: int = advance(*numbers, arrays.table, unlocked=self.unlocked)
        if arrays.sleepy:
            self.last_contacts.note_sleepers()
        return done

    def _end_threads(self) -> None:
        """End the threads that solve islands; the next steps start them again."""
        if self._helpers is not None:
            self._helpers.end()
            self._helpers = None

    # Attaching ----------------------------------------------------------------------------------
    def attach(self, key: Any, one: BodyLink, other: BodyLink) -> None:
        """See api.Engine."""
        self.attach_by_joint(key, one, other)

    def attach_by_joint(
        self, key: Any, parent: BodyLink, child: BodyLink, joint: Joint | None = None
    ) -> bool:
        """See api.Engine; None: a fixed joint."""
        frame = self.frame_of(child)
        if parent != WORLD:
            frame = self.frame_of(parent).inverse() * frame
        self._set_attachment(key, Attachment(parent, child, frame, joint=joint))
        return True

    def frame_of(self, link: BodyLink) -> Pose:
        """Pose of a link's frame."""
        return Pose(*self.bodies[link[0]].link_motion(link[1])[:2])

    def _set_attachment(self, key: Any, attachment: Attachment) -> None:
        """A link is held by another one, or by a joint, or not any more."""
        self.refresh()
        for number, _ in (attachment.parent, attachment.child):
            if number in self.bodies:
                self.bodies[number].wake()
        self.contents.attached[key], self.is_built = attachment, False

    def attach_again(self, key: Any) -> bool:
        """See api.Engine."""
        return self._switch_attachment(key, True)

    def detach(self, key: Any) -> bool:
        """See api.Engine."""
        return self._switch_attachment(key, False)

    def _switch_attachment(self, key: Any, is_on: bool) -> bool:
        attachment = self.contents.attached.get(key)
        if attachment is not None:
            self._set_attachment(key, replace(attachment, is_on=is_on))
        return attachment is not None

    def attached_state(self, key: Any) -> tuple[float, float]:
        """See api.Engine; zeros where nothing is attached."""
        self.refresh()
        row = self.arrays.attached.get(key)
        if row is None:
            return 0.0, 0.0
        return float(self.joint_rows[row, q.ANGLE]), float(self.joint_rows[row, q.RATE])

    def add_attached_effort(self, key: Any, effort: float) -> None:
        """See api.Engine."""
        self.refresh()
        row = self.arrays.attached.get(key)
        if row is not None:
            self.joint_rows[row, q.EFFORT] += effort

    def attachments(self) -> dict[Any, tuple[BodyLink, BodyLink]]:
        """See api.Engine."""
        held = self.contents.attached.items()
        return {key: (a.parent, a.child) for key, a in held if a.is_on and a.joint is None}

    # Contacts -----------------------------------------------------------------------------------
    def all_contacts(self) -> tuple[Array, Array, Array]:
        """See api.Engine."""
        points = [
            (point, normal, float(np.dot(force, normal)))
            for _, _, point, normal, _, force in self.last_contacts.last()
        ]
        places, normals, forces = zip(*points) if points else ((), (), ())
        return np.reshape(places, (-1, 3)), np.reshape(normals, (-1, 3)), np.array(forces, float)

    # Rays ---------------------------------------------------------------------------------------
    def cast_rays(self, rays: Rays) -> Array:
        """See api.Engine."""
        scene, is_whole = self._ray_scene()
        ranges = scene.cast(rays)
        return ranges if is_whole else np.minimum(ranges, self.mirror.client.cast_rays(rays))

    def _ray_scene(self) -> tuple[RayScene, bool]:
        """What rays are cast at, and whether it is all."""
        self.refresh()
        if self._rays is None:
            every = [*self._immobile_shapes(), *self._moving_shapes()]
            known = [shape for shape in every if shape.is_known()]
            self._rays = RayScene(known, self.rows), len(known) == len(every)
        return self._rays

    def _immobile_shapes(self) -> Iterator[RayShape]:
        for body in self.contents.immobile.values():
            for shape in body.root.collisions:
                tree = self._shapes.tree(shape)
                yield RayShape(-1, shape.geometry, body.base * shape.pose, tree)

    def _moving_shapes(self) -> Iterator[RayShape]:
        for body in self.contents.moving.values():
            for row, name in enumerate(body.names, body.first):
                link = body.model.links[name]
                center = Pose(tuple((-link.center).tolist()))
                for shape in link.collisions:
                    tree = self._shapes.tree(shape)
                    yield RayShape(row, shape.geometry, center * shape.pose, tree)

    def mesh_scene(
        self, meshes: Sequence[tuple[int, Pose, Array]], positions: Array, orientations: Array
    ) -> MeshScene:
        """See api.Engine."""
        for _, _, triangles in meshes:
            if id(triangles) not in self._trees:
                self._trees[id(triangles)] = triangles, make_tree(triangles, (1.0, 1.0, 1.0))
        trees = [(row, pose, self._trees[id(each)][1]) for row, pose, each in meshes]
        return MeshScene(trees, positions, orientations)


def _copy_state(body: OdeBody, rows: Array, joint_rows: Array) -> None:
    """Put a body's rows where others of it were, with what its joints were told."""
    body.rows[:, : q.MASS] = rows[:, : q.MASS]
    body.joint_rows[:, q.FMAX : q.J_SIZE] = joint_rows[:, q.FMAX : q.J_SIZE]
