"""Steps of an engine made as Gazebo's ODE makes them.

What moves is numbers in arrays here (see quickstep/ and ode_arrays.py). PyBullet finds the contacts
of shapes that quickstep does not know, such as meshes that cannot be read (ode_contacts.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.controllers.effort_row import EffortRow
from bullet_sim.description.lump import LumpedModel, chain_of, free_coordinates
from bullet_sim.description.world import OdeSettings
from bullet_sim.engine import tables
from bullet_sim.engine.ode_arrays import (
    ArrayBuilder,
    Attachment,
    DynamicModel,
    Models,
    StaticModel,
)
from bullet_sim.engine.ode_contacts import Contact, Contacts
from bullet_sim.engine.ode_scene import BodyLink
from bullet_sim.engine.ode_shapes import ShapeCache
from bullet_sim.engine.ode_threads import Helpers, processors
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.library import advance, compile_once, is_compiled
from bullet_sim.engine.rays import RayScene, RayShape
from bullet_sim.engine.told import Told
from bullet_sim.pose import Array, Pose, Quat, Vec3, Vector, compose, matrix_from_quaternion

if TYPE_CHECKING:
    from bullet_sim.controllers.handle import JointHandle
    from bullet_sim.engine.engine import Engine

# Parameters of joints by ODE's names -> column of their rows, attribute of Joint.
_PARAMETERS = {
    "erp": (q.ERP, "erp"),
    "cfm": (q.CFM, "cfm"),
    "stop_erp": (q.STOP_ERP, "stop_erp"),
    "stop_cfm": (q.STOP_CFM, "stop_cfm"),
    "fudge_factor": (q.STOP_PUSH, "stop_push"),
    "fmax": (q.FMAX, "friction"),
    "vel": (q.SPEED, ""),
}
_ROUNDING = 1e-15  # [m] and of a quaternion: what PyBullet leaves of 0 between two frames
_UNTURNED = (0.0, 0.0, 0.0, 1.0)


def _without_rounding(values: Vector) -> Any:
    """Values with exact zeros: in Gazebo a robot that is balanced on two wheels stands by them."""
    return tuple(0.0 if abs(value) < _ROUNDING else value for value in values)


class OdeSolver:
    """Moves an engine's bodies.

    Args:
        told: what the engine was told of its bodies last.

    Attributes:
        settings: of the world.
        is_ahead: bodies are not where the engine's copies of them are.
        unlocked: let other threads of Python run during steps: where each has a world of its own.
    """

    def __init__(self, engine: Engine, told: Mapping[int, Told]) -> None:
        self.unlocked = False
        self._helpers: Helpers | None = None
        self._engine, self._told = engine, told
        self._numbers, self._gravity = np.zeros(q.S_SIZE), np.zeros(3)
        self.configure(OdeSettings())
        self._shapes = ShapeCache(lambda: engine.client)
        self.clear()

    def configure(self, settings: OdeSettings) -> None:
        """Set what a world file says of the solver, before bodies are added."""
        self.settings = settings
        self.end_threads()
        self._engine.solver_iterations = settings.iterations
        numbers = self._numbers
        numbers[q.S_RELAXATION], numbers[q.S_ERP] = settings.relaxation, settings.erp
        numbers[q.S_CFM], numbers[q.S_RESCALE] = settings.cfm, float(settings.evens_inertias)

    @staticmethod
    def is_compiled() -> bool:
        """Whether this version of the solver was compiled before, next to its source."""
        return is_compiled()

    def compile(self) -> None:
        """Compile the solver, unless that was done; else the first step does."""
        compile_once()
        self._advance(0, -1)
        self.ray_scene()[0].cast(np.zeros(3), np.zeros((0, 3)), 0.0, 0.0)

    def end_threads(self) -> None:
        """End the threads that solve islands; the next steps start them again."""
        if self._helpers is not None:
            self._helpers.end()
            self._helpers = None

    def clear(self) -> None:
        """All bodies are gone."""
        self.is_ahead = False
        self._models = Models()
        self._parts = self._models.moving
        self._unread: set[int] = set()  # bodies whose state is what was told of them
        self._placed: set[int] = set()  # bodies whose rows have been where something is
        self._is_built = False
        self._contacts = Contacts(self._engine, self._models)
        self._resting: set[int] = set()  # bodies that sleep where their copies are
        self._build_arrays()

    # models -------------------------------------------------------------------------------------
    def add(
        self,
        body: int,
        model: LumpedModel,
        links: Mapping[str, int],
        static: bool,
        fixed: bool,
        may_sleep: bool,
        touching: Sequence[tuple[str, str]],
    ) -> None:
        """Take a body that was loaded.

        Args:
            model: of which it was made.
            links: name -> the engine's index.
            static: it never moves.
            fixed: its root link never moves.
            may_sleep: it may sleep while it rests, if it has no joints.
            touching: pairs of its links that collide with each other.
        """
        self._is_built = False
        if static:
            self._models.static[body] = StaticModel(body, model.links[model.root])
            return
        joints = {joint.child: joint for joint in model.tree()}
        names = list(model.links)
        moving = [name for name in names if not (fixed and name == model.root)]
        moved = [joints[name] for name in names if name in joints]
        listed = (*model.joints, *model.welds)
        for number, joint in enumerate(listed):
            if joint.closes:  # behind those that come before it in the file
                before = {each.name for each in listed[:number]}
                places = [place for place, each in enumerate(moved, 1) if each.name in before]
                moved.insert(max(places, default=0), joint)
        self._placed.discard(body)
        self._parts[body] = DynamicModel(
            body, moving, moved, links, model, fixed, may_sleep and not joints, touching
        )
        if fixed:
            self._models.static[body] = StaticModel(body, model.links[model.root])
        self._unread.add(body)

    def remove(self, body: int) -> None:
        """A body was removed."""
        self.wake()
        self._is_built = False
        self._parts.pop(body, None)
        self._models.static.pop(body, None)
        self._unread.discard(body)
        self._placed.discard(body)
        self._arrays.models.discard(body)  # another body may get its number
        self._models.ghosts.discard(body)
        attached = self._models.attached
        for key in [k for k, it in attached.items() if body in (it.parent[0], it.child[0])]:
            del attached[key]
        for told in (self._models.filtered, self._models.friction):
            for key in [key for key in told if key[0] == body]:
                del told[key]

    def read_later(self, body: int) -> None:
        """The engine was told where a body is or how it moves."""
        self._unread.add(body)
        if body in self._models.static:
            self.wake()
            self._is_built = False  # planes and boxes

    def attach(self, key: Any, attachment: Attachment) -> None:
        """A link is held by another one, or by a joint, or not any more."""
        self.refresh()
        self.wake(attachment.parent[0])
        self.wake(attachment.child[0])
        self._models.attached[key], self._is_built = attachment, False

    def attachments(self) -> dict[Any, Attachment]:
        """What was attached, by its keys, also where it is let go by now."""
        return self._models.attached

    def attached_state(self, key: Any) -> tuple[float, float]:
        """Position [rad, m] and velocity of the joint of what is attached; zeros where none is."""
        self.refresh()
        row = self._arrays.attached.get(key)
        if row is None:
            return 0.0, 0.0
        return float(self.joints[row, q.ANGLE]), float(self.joints[row, q.RATE])

    def add_attached_effort(self, key: Any, effort: float) -> None:
        """An effort acts on such a joint in the next step."""
        self.refresh()
        row = self._arrays.attached.get(key)
        if row is not None:
            self.joints[row, q.EFFORT] += effort

    def set_bitmask(self, body: int, link: int, bits: int) -> None:
        """A link touches only what shares a bit."""
        self._models.filtered[body, link], self._is_built = bits, False

    def set_ghost(self, body: int) -> None:
        """A body touches only what never moves."""
        self._models.ghosts.add(body)
        self._is_built = False

    def set_friction(self, body: int, link: int, friction: float) -> None:
        """Set both coefficients of all shapes of a link."""
        self._models.friction[body, link], self._is_built = friction, False

    def set_slip(self, body: int, link: int, slip1: float, slip2: float) -> None:
        """Set slip1 and slip2 of all shapes of a link, until the arrays are built again."""
        self.refresh()
        row = self._arrays.rows.get((body, link))
        if row is None:
            return
        scene = self._state.scene
        for shape in np.flatnonzero(scene.kinds[:, 0] == row):
            scene.shapes[shape, q.G_SLIP : q.G_SLIP + 2] = slip1, slip2
            solid = scene.solid_of[shape]
            if solid >= 0:
                scene.faces[solid, q.P_SLIP : q.P_SLIP + 2] = slip1, slip2

    def _build(self) -> None:
        """Arrays of what is there now; states and what joints are told are kept."""
        kept = {
            part.body: (self._rows(part).copy(), self._joint_rows(part).copy())
            for part in self._parts.values()
            if part.body in self._arrays.models
        }
        moved = {
            key: self.joints[row, q.ANGLE : q.RATE + 1].copy()
            for key, row in self._arrays.attached.items()
            if key in self._models.attached and self._models.attached[key].joint is not None
        }
        self._build_arrays()
        for body, (bodies, joints) in kept.items():
            part = self._parts[body]
            state = slice(0, q.MASS)
            self._rows(part)[:, state] = bodies[:, state]
            moving = slice(q.FMAX, q.J_SIZE)
            self._joint_rows(part)[:, moving] = joints[:, moving]
        for key, values in moved.items():
            if key in self._arrays.attached:
                self.joints[self._arrays.attached[key], q.ANGLE : q.RATE + 1] = values
        self._unread |= self._parts.keys() - kept.keys()
        self._sort()
        self._is_built = True

    def _build_arrays(self) -> None:
        self.end_threads()
        builder = ArrayBuilder(self._engine, self._shapes, self.settings, self._models)
        self._arrays = arrays = builder.build(self._numbers, self._gravity)
        self._state = state = arrays.state
        self.bodies, self.joints = state.system.bodies, state.system.joints
        # A few numbers of it are read and written faster so, and without giving up Python's lock.
        self._numbers_of_joints: Any = memoryview(self.joints.reshape(-1))
        self._contacts.use(arrays)
        self._ray_scene: tuple[RayScene, bool] | None = None
        self._sort()

    def _sort(self) -> None:
        """Bodies in the order of the last step."""
        self._state.sequence[:] = np.argsort(self.bodies[:, q.PLACE], kind="stable")

    def _rows(self, part: DynamicModel) -> Array:
        return self.bodies[part.first : part.first + len(part.names)]

    def _joint_rows(self, part: DynamicModel) -> Array:
        return self.joints[part.first_joint : part.first_joint + part.rows]

    def _attached_rows(self) -> Array:
        """Rows of the joints of what is attached, which follow those of the models."""
        return self.joints[sum(part.rows for part in self._parts.values()) :]

    # states -------------------------------------------------------------------------------------
    def _read(self) -> None:
        """Take over what was told."""
        for body in sorted(self._unread):
            part = self._parts.get(body)
            if part is None:
                continue
            for row, (position, velocity) in zip(part.order, self._told[body].states):
                self.joints[row, q.ANGLE] = self.joints[row, q.REACHED] = position
                self.joints[row, q.RATE] = velocity
            self._place_links(part)
            self.wake(body)
        self._unread.clear()

    def _place_links(self, part: DynamicModel) -> None:
        """Links where the base and the joints' positions have them."""
        position, orientation, linear, angular = self._told[part.body].motion()
        pose = Pose(_without_rounding(position), _without_rounding(orientation))
        root: tuple[Pose, Any, Any] = (pose, linear, angular)
        motions = {part.shapes.root: root}
        rows = dict(zip(part.names, self._rows(part)))
        before, part.frame = self._root_frame(part), pose
        for joint in part.shapes.loose:
            motions[joint.child] = pose * joint.origin, linear, angular
            if before is not None:  # it stays where it is relative to the root link
                there = before.inverse() * self._frame(part, joint.child)
                velocity, spin = self._velocity(part, joint.child)
                motions[joint.child] = pose * there, velocity, spin
        self._placed.add(part.body)
        for joint, state in zip(part.joints, self._joint_rows(part)):
            if joint.closes:
                continue
            pose, velocity, spin = motions[joint.parent]
            axis, angle = np.array(joint.axis) / np.linalg.norm(joint.axis), state[q.ANGLE]
            frame = pose * joint.origin
            along = frame.matrix @ axis
            if joint.kind == "prismatic":
                frame = Pose(tuple(frame.position + angle * along), frame.orientation)
                moved, turned = state[q.RATE] * along, np.zeros(3)
            else:
                turn = (*(math.sin(0.5 * angle) * axis).tolist(), math.cos(0.5 * angle))
                frame = frame * Pose((0.0, 0.0, 0.0), turn)
                moved, turned = np.zeros(3), state[q.RATE] * along
                if joint.kind == "screw":
                    x, y, z = np.add(frame.position, angle / state[q.PITCH] * along).tolist()
                    frame = Pose((x, y, z), frame.orientation)
                    moved = state[q.RATE] / state[q.PITCH] * along
            arm = np.subtract(frame.position, pose.position)
            velocity = np.add(velocity, np.cross(spin, arm)) + moved
            motions[joint.child] = frame, velocity, np.add(spin, turned)
        for name, row in rows.items():
            pose, velocity, spin = motions[name]
            arm = pose.matrix @ part.shapes.links[name].center
            row[q.POS : q.POS + 3] = np.add(pose.position, arm)
            row[q.QUAT : q.QUAT + 4] = pose.orientation
            row[q.VEL : q.VEL + 3] = np.add(velocity, np.cross(spin, arm))
            row[q.VEL + 3 : q.VEL + 6] = spin

    def _frame(self, part: DynamicModel, name: str) -> Pose:
        """Pose of the frame of a link that has a row."""
        row = part.first + part.names.index(name)
        position, orientation = self.bodies[row, : q.QUAT], self.bodies[row, q.QUAT : q.VEL]
        x, y, z = position.tolist()
        frame = compose((x, y, z), orientation.tolist(), self._arrays.inward[row], _UNTURNED)
        return Pose(*frame)

    def _velocity(self, part: DynamicModel, name: str) -> tuple[Array, Array]:
        """Velocities of the origin of a link's frame [m/s, rad/s]."""
        row = self.bodies[part.first + part.names.index(name)]
        spin = row[q.VEL + 3 : q.VEL + 6].copy()
        center: Any = part.shapes.links[name].center
        arm = matrix_from_quaternion(row[q.QUAT : q.VEL]) @ center
        return row[q.VEL : q.VEL + 3] - np.cross(spin, arm), spin

    def _root_frame(self, part: DynamicModel) -> Pose | None:
        """Pose of the root link's frame; None: nothing has put it anywhere yet."""
        if not part.shapes.loose or part.body not in self._placed:
            return None
        return part.frame if part.is_fixed else self._frame(part, part.shapes.root)

    def chain_positions(self, body: int) -> list[float]:
        """Positions [m, rad] of a body's joints of the engine's `chains`."""
        self.refresh()
        part = self._parts[body]
        found: dict[str, float] = {}
        for joint in part.shapes.loose:
            root, pose = self._root_frame(part), self._frame(part, joint.child)
            assert root is not None
            names = [link.name for link in chain_of(joint)]
            found.update(zip(names, free_coordinates(joint, root, pose)))
        for joint, row in zip(part.joints, self._joint_rows(part)):
            if joint.kind == "screw":
                found[chain_of(joint)[0].name] = row[q.ANGLE] / row[q.PITCH]
        return [found[name] for name in self._engine.chains[body]]

    def place_link(self, body: int, link: int, pose: Pose, linear: Vector, angular: Vector) -> bool:
        """Put one link to a pose, with a velocity of its center of mass.

        Returns:
            Whether it moves.
        """
        self.refresh()
        row = self._arrays.rows.get((body, link))
        if row is None:
            return False
        self.wake(body)
        x, y, z = self._arrays.inward[row]
        center = pose * Pose((-x, -y, -z))
        numbers = self.bodies[row]
        numbers[q.POS : q.POS + 3], numbers[q.QUAT : q.QUAT + 4] = center.position, pose.orientation
        numbers[q.VEL : q.VEL + 6] = (*linear, *angular)
        self.is_ahead = True
        return True

    def gather(self, body: int) -> None:
        """Have a body's loose links start anew where its root link is told to be."""
        self._placed.discard(body)
        self.read_later(body)

    def tell(self, body: int, told: Told) -> bool:
        """Have `told` say how a body moves now.

        Returns:
            Whether it moves at all.
        """
        part = self._parts.get(body)
        if part is None or body in self._unread:
            return part is not None  # what was told is newer
        if not np.isfinite(self._rows(part)[:, : q.PLACE]).all():
            told.lose()
            return True
        if part.is_fixed:
            told.linear = told.angular = (0.0, 0.0, 0.0)
        else:
            numbers = self.bodies[part.first, : q.PLACE].tolist()
            x, y, z, *orientation = numbers[: q.VEL]
            inward = self._arrays.inward[part.first]
            told.pose = Pose(*compose((x, y, z), orientation, inward, _UNTURNED))
            told.linear, told.angular = (
                (numbers[first], numbers[first + 1], numbers[first + 2])
                for first in (q.VEL, q.VEL + 3)
            )
        states = self.joints[part.order][:, [q.ANGLE, q.RATE]].tolist() if part.order else []
        told.states = [(position, velocity) for position, velocity in states]
        return True

    def is_resting(self, body: int) -> bool:
        """Whether a body sleeps as at the last call: its copies are where it is."""
        part = self._parts.get(body)
        if part is None or not part.may_sleep or body in self._unread:
            return False
        if not self._rows(part)[:, q.ASLEEP].all():
            self._resting.discard(body)
            return False
        was = body in self._resting
        self._resting.add(body)
        return was

    def refresh(self) -> None:
        """Make the arrays tell what is there now."""
        if not self._is_built:
            self._build()
        if self._unread:
            self._read()

    def save(self) -> dict[str, Any]:
        """State of all that moves."""
        self.refresh()
        return {
            "bodies": {b: self._rows(part).copy() for b, part in self._parts.items()},
            "joints": {b: self._joint_rows(part).copy() for b, part in self._parts.items()},
            "held": self._attached_rows().copy(),
            "sleepers": self._contacts.sleepers,
            "attached": dict(self._models.attached),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a state of save(); the bodies have to be the same."""
        if state["attached"] != self._models.attached:
            self._models.attached, self._is_built = dict(state["attached"]), False
        self.refresh()
        for body, part in self._parts.items():
            self._rows(part)[:, : q.MASS] = state["bodies"][body][:, : q.MASS]
            self._rows(part)[:, q.FORCE : q.FORCE + 6] = 0.0
            moving = slice(q.FMAX, q.J_SIZE)
            self._joint_rows(part)[:, moving] = state["joints"][body][:, moving]
        self._attached_rows()[:] = state["held"]
        self._sort()
        self._unread.clear()
        self._contacts.restore(state["sleepers"])
        self._resting.clear()
        self.is_ahead = True

    # steps --------------------------------------------------------------------------------------
    def step(self, count: int) -> None:
        """Make time steps."""
        self.refresh()
        if not len(self.bodies):
            return
        self._gravity[:] = self._engine.gravity
        while count > 0:
            given = self._find() if self._arrays.always else -1
            count -= self._advance(1 if given >= 0 else count, given)
            if count > 0 and self._arrays.watch and not self._arrays.always:
                count -= self._advance(1, self._find())
        self.is_ahead = True

    @contextmanager
    def controlled(self, pids: Sequence[EffortRow], notes: bool) -> Iterator[None]:
        """Compute PIDs before each of the steps that are made meanwhile; each has the state after
        the last one then.

        Args:
            notes: note the joints' positions before each step, for noted(), of which
                MAX_NOTED_STEPS may be made.
        """
        self.refresh()
        table, active = self._state.pids, self._state.active
        for k, pid in enumerate(pids):
            part = self._parts[pid.body]
            goal = q.GOALS[pid.goal], pid.target, *pid.limits
            table[k] = (
                part.order[pid.joint], *pid.of_force, *goal, *pid.gains, *pid.bounds, *pid.state
            )  # fmt: skip
        active[:] = len(pids), notes, 0
        try:
            yield
        finally:
            active[:2] = 0
        for state, pid in zip(table[: len(pids), q.PID_STATE :].tolist(), pids):
            pid.state = state

    def noted(self, body: int, joints: Iterable[int], count: int) -> list[list[float]]:
        """Positions [rad, m] of some joints of a body before each of the last `count` steps."""
        order = self._parts[body].order
        rows: list[list[float]] = self._state.noted[:count, [order[k] for k in joints]].tolist()
        return rows

    def _advance(self, count: int, given: int) -> int:
        step, iterations = self._engine.time_step, self.settings.iterations
        arrays, threads = self._arrays, self.settings.island_threads
        if threads > 1 and self._helpers is None and len(arrays.models) > 1:
            count_of_helpers = min(threads, processors()) - 1
            self._helpers = Helpers(self, self._state, arrays.table, count_of_helpers)
        numbers = count, given, step, iterations, arrays.watch, arrays.sleepy
        done: int = advance(*numbers, arrays.table, unlocked=self.unlocked)
        if arrays.sleepy:
            self._contacts.note_sleepers()
        return done

    def wake(self, body: int | None = None) -> None:
        """Let a body, or all, be awake."""
        for part in self._parts.values() if body is None else [self._parts.get(body)]:
            if part is not None and part.may_sleep and part.body in self._arrays.models:
                self._rows(part)[:, q.REST : q.ASLEEP + 1] = q.REST_TIME, q.REST_COUNT, 0.0

    def is_asleep(self, body: int) -> bool:
        """Whether a body sleeps."""
        self.refresh()
        part = self._parts.get(body)
        return part is not None and part.may_sleep and bool(self._rows(part)[:, q.ASLEEP].all())

    def _find(self) -> int:
        return self._contacts.find()

    # joints -------------------------------------------------------------------------------------
    def _ready(self, body: int) -> DynamicModel:
        """A moving model, with rows of its own."""
        if not self._is_built:
            self._build()
        return self._parts[body]

    def _joint(self, body: int, joint: int) -> Array:
        row = self._ready(body).order[joint]  # first: it may make another array
        return self.joints[row]

    def set_velocity(self, body: int, joint: int, velocity: float, effort: float) -> None:
        """A joint's motor tracks a velocity with at most an effort."""
        row, numbers = q.J_SIZE * self._ready(body).order[joint], self._numbers_of_joints
        numbers[row + q.SPEED], numbers[row + q.FMAX] = velocity, effort
        numbers[row + q.TARGET] = numbers[row + q.IMPOSED] = math.nan

    def impose_velocity(self, body: int, joint: int, velocity: float) -> None:
        """The link below a joint is given this velocity before each step."""
        self.release(body, joint)
        self._joint(body, joint)[q.IMPOSED] = velocity

    def set_position(
        self, body: int, joint: int, position: float, effort: float, speed: float
    ) -> None:
        """What is below a joint is put to a position, which it reaches at most at a speed."""
        row = self._joint(body, joint)
        if math.isnan(row[q.TARGET]):
            row[q.REACHED] = row[q.ANGLE]
        row[q.SPEED], row[q.FMAX] = 0.0, effort
        row[q.TARGET], row[q.MAX_SPEED], row[q.IMPOSED] = position, speed, math.nan

    def impose_position(self, body: int, joint: int, position: float) -> None:
        """As set_position, at once; nothing but its friction holds the joint in between."""
        self.set_position(body, joint, position, self._ready(body).joint(joint).friction, math.inf)

    def release(self, body: int, joint: int) -> None:
        """A joint moves freely, but for its friction."""
        if body not in self._arrays.models:
            return  # as it is loaded
        part = self._parts[body]
        row = self.joints[part.order[joint]]
        row[q.SPEED], row[q.TARGET], row[q.IMPOSED] = 0.0, math.nan, math.nan
        row[q.FMAX] = part.joint(joint).friction

    def add_effort(self, body: int, joint: int, effort: float) -> None:
        """An effort acts on a joint in the next step."""
        row = q.J_SIZE * self._ready(body).order[joint]  # first: it may make other numbers
        self._numbers_of_joints[row + q.EFFORT] += effort

    def set_limits(self, body: int, joint: int, lower: float, upper: float) -> None:
        """Change a joint's limits."""
        row = self._joint(body, joint)
        row[q.LOWER], row[q.UPPER] = lower, upper
        described = self._parts[body].joint(joint)
        described.lower, described.upper = lower, upper

    def set_damping(self, body: int, joint: int, damping: float) -> None:
        """Change a joint's damping."""
        self._joint(body, joint)[q.DAMPING] = damping

    def set_parameter(self, body: int, joint: int, name: str, value: float) -> None:
        """Change a joint's erp, cfm, stop_erp, stop_cfm, fudge_factor, fmax or vel.

        The last two are the effort [N m, N] and the velocity [rad/s, m/s] of its motor. The effort
        is that of its friction, too, which it has again when it is released.
        """
        column, attribute = _PARAMETERS[name]
        self._joint(body, joint)[column] = value
        if attribute:
            setattr(self._parts[body].joint(joint), attribute, value)

    def joint_states(self, body: int) -> list[tuple[float, float, tuple[float, ...], float]]:
        """(position, velocity, (), motor's effort) of each of the engine's joints."""
        part, states = self._parts.get(body), self._told[body].states
        if part is None or not states:
            return []
        if body not in self._arrays.models:  # it is where it was told to be
            return [(position, velocity, (), 0.0) for position, velocity in states]
        self.refresh()
        numbers, count = part.measured(self._numbers_of_joints), len(part.order)
        motors = numbers[2 * count :]
        return [
            (angle, rate, (), motor) for angle, rate, motor in zip(numbers, numbers[count:], motors)
        ]

    def read_joints(self, body: int, handles: Iterable[JointHandle]) -> None:
        """As Engine.read_joints."""
        self.refresh()
        part = self._parts.get(body)
        if part is None or not part.order:
            return
        numbers = part.measured(self._numbers_of_joints)
        for handle, angle, rate in zip(handles, numbers, numbers[len(part.order) :]):
            handle.position, handle.velocity = angle, rate

    def joint_load(self, body: int, joint: int) -> tuple[Array, Array, float]:
        """As Engine.joint_load."""
        self.refresh()
        number = self._parts[body].order[joint]
        numbers, row = self.joints[number], self._state.system.types[number, 1]
        turn = matrix_from_quaternion(self.bodies[row, q.QUAT : q.QUAT + 4]).T
        force = turn @ numbers[q.WRENCH : q.WRENCH + 3]
        torque = turn @ numbers[q.WRENCH + 3 : q.WRENCH + 6]
        center = self._parts[body].link(row).center
        return force, torque + np.cross(center, force), numbers[q.MOTOR]

    # bodies -------------------------------------------------------------------------------------
    def link_motion(self, body: int, link: int) -> tuple[Vec3, Quat, Vec3, Vec3, Vec3] | None:
        """Position [m] and quaternion of a link's frame, its center of mass [m], linear [m/s] and
        angular velocity [rad/s] of that; None: see tell()."""
        if not self._is_built or body in self._unread or body not in self._parts:
            return None
        row = self._arrays.rows.get((body, link))
        if row is None:
            return None
        numbers = self.bodies[row, : q.PLACE].tolist()
        if not math.isfinite(sum(numbers)):
            return None
        x, y, z, *orientation = numbers[: q.VEL]
        position, turned = compose((x, y, z), orientation, self._arrays.inward[row], _UNTURNED)
        return position, turned, (x, y, z), tuple(numbers[q.VEL : q.VEL + 3]), tuple(numbers[-3:])

    def add_force(self, body: int, link: int, force: Vec3, point: Vec3, torque: Vec3) -> None:
        """A force at a world point and a torque act on a link in the next step."""
        self.refresh()
        row = self._arrays.rows.get((body, link))
        if row is None:  # it is fixed to the world
            return
        self.wake(body)
        arm = np.subtract(point, self.bodies[row, q.POS : q.POS + 3])
        self.bodies[row, q.FORCE : q.FORCE + 3] += force
        self.bodies[row, q.FORCE + 3 : q.FORCE + 6] += np.add(torque, np.cross(arm, force))

    def set_velocities(self, body: int, linear: Vector, angular: Vector) -> bool:
        """Give the centers of mass of all links of a body one velocity [m/s, rad/s].

        Returns:
            Whether the body moves.
        """
        part = self._parts.get(body)
        if part is None or part.is_fixed and not part.shapes.loose:
            return False
        self.refresh()
        self.wake(body)
        self._rows(part)[:, q.VEL : q.VEL + 6] = (*linear, *angular)
        self._joint_rows(part)[:, q.RATE] = 0.0
        self.is_ahead = True
        return True

    def set_mass(self, body: int, link: int, mass: float, inertia: Array) -> None:
        """Change a link's mass and inertia (3, 3)."""
        self.refresh()
        row = self._arrays.rows.get((body, link))
        if row is None:
            return
        self.wake(body)
        described = self._parts[body].link(row)
        described.mass, described.inertia = mass, inertia
        tables.set_inertia(self.bodies[row], mass, inertia)

    def set_link_gravity(self, body: int, link: int, is_on: bool) -> None:
        """Have gravity act on a link, or not."""
        self.refresh()
        row = self._arrays.rows.get((body, link))
        if row is not None:
            self.wake(body)
            self._parts[body].link(row).gravity = is_on
            self.bodies[row][q.GRAVITY] = float(is_on)

    def contacts(self) -> list[Contact]:
        """Contacts of the last step; of what sleeps those with which it fell asleep."""
        return self._contacts.last()

    def contacts_of(self, link: BodyLink) -> list[Contact]:
        """As contacts(), of one link."""
        return self._contacts.of_link(link)

    def is_first(self, one: BodyLink, two: BodyLink) -> bool:
        """Whether the first of two links that touch is the first of them in Gazebo, too."""
        return self._contacts.is_first(one, two)

    # rays ---------------------------------------------------------------------------------------
    def ray_scene(self) -> tuple[RayScene, bool]:
        """What rays are cast at, but for ghosts, which they pass; and whether it is all."""
        self.refresh()
        if self._ray_scene is None:
            every = [*self._static_shapes(), *self._moving_shapes()]
            known = [shape for shape in every if shape.is_known()]
            self._ray_scene = RayScene(known, self.bodies), len(known) == len(every)
        return self._ray_scene

    def _static_shapes(self) -> Iterator[RayShape]:
        for model in self._models.static.values():
            if model.body in self._models.ghosts:
                continue
            frame = Pose(*self._engine.base_pose(model.body))
            for shape in model.link.collisions:
                tree = self._shapes.tree(shape)
                yield RayShape(model.body, -1, shape.geometry, frame * shape.pose, tree)

    def _moving_shapes(self) -> Iterator[RayShape]:
        for model in self._models.moving.values():
            if model.body in self._models.ghosts:
                continue
            for row, name in enumerate(model.names, model.first):
                link = model.shapes.links[name]
                center = Pose(tuple((-link.center).tolist()))
                for shape in link.collisions:
                    tree = self._shapes.tree(shape)
                    yield RayShape(model.body, row, shape.geometry, center * shape.pose, tree)
