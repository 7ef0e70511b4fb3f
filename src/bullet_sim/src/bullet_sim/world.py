"""The world: models in an engine, simulated time, and states to go back to."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bullet_sim.component import Stateful
from bullet_sim.controllers import Controller
from bullet_sim.description.model import ModelDescription
from bullet_sim.description.world import (
    DEFAULT_STEP,
    MIN_STEP,
    LinkMotion,
    Place,
    Scene,
    WorldDescription,
)
from bullet_sim.engine import Engine, make_engine
from bullet_sim.engine.api import EngineState
from bullet_sim.engine.efforts import MAX_RECORDED
from bullet_sim.errors import ModelError, SimError, WorldError
from bullet_sim.files import OwnFolder
from bullet_sim.formats import urdf
from bullet_sim.formats.lumping import LEAVE_OUT, check_massless
from bullet_sim.formats.materials import Resolve
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.meshes.prepare import prepare_meshes
from bullet_sim.models.changes import Forces
from bullet_sim.models.model import PERIOD, Model, Placed, implausible_state
from bullet_sim.models.wind import WindForces
from bullet_sim.pose import PLACEABLE, Array, Pose, Vec3
from bullet_sim.sensors.visible import VisibleScene
from bullet_sim.snapshot import BodySource, Snapshot
from bullet_sim.xml_reader import Node

COLD = (
    "contacts start anew, as models were reloaded or deleted since: the last digits will differ "
    "from those that followed then"
)


@dataclass(frozen=True)
class WorldState:
    """State of a world.

    Attributes:
        controllers: of each model, as they were loaded.
        engine: of its bodies.
        parts: states of what is computed between steps, see World._parts().
        placed: what Model.set_state has set, of each model.
        time_step: [s].
        next_check: time of the next check for implausible states [s].
    """

    models: dict[str, Model]
    bodies: tuple[int, ...]
    controllers: tuple[tuple[Controller, ...], ...]
    engine: EngineState
    parts: tuple[dict[str, Any], ...]
    placed: tuple[Placed | None, ...]
    time_step: float
    step_count: int
    next_check: float


def _bodies(models: Mapping[str, Model]) -> tuple[int, ...]:
    numbers = (model.body.number for model in models.values())
    return tuple(number for number in numbers if number >= 0)  # not of actors


def _are_first(bodies: tuple[int, ...]) -> bool:
    """Whether a cleared engine gives bodies these numbers."""
    return bodies == tuple(range(len(bodies)))


def _controllers(model: Model) -> tuple[Controller, ...]:
    return () if model.manager is None else model.manager.controllers()


def _names(controllers: Iterable[Controller]) -> str:
    return ", ".join(controller.config.name for controller in controllers) or "(none)"


class ModelOrder(Stateful):
    """Models of the world file in file order, then the others by name.

    The last bits of the engine's results depend on the order in which bodies were loaded, and
    programs that spawn models at the same time do so in any order.

    Attributes:
        of_file: names of the models that a world file contains, in its order.
        fresh: no step was made since the start or the last reset.
        changed, deleted: models were spawned or deleted; some were deleted, since they were sorted.
    """

    STATE = ("of_file", "fresh", "changed", "deleted")

    def __init__(self) -> None:
        self.of_file: tuple[str, ...] = ()
        self.reset()

    def reset(self) -> None:
        """Note that all models were loaded into a cleared engine."""
        self.fresh, self.changed, self.deleted = True, False, False

    def sorted(self, names: Iterable[str]) -> list[str]:
        """Names in the order in which their models are loaded."""
        first = {name: number for number, name in enumerate(self.of_file)}
        return sorted(names, key=lambda name: (first.get(name, len(first)), name))


class World:
    """Everything that is simulated.

    Args:
        time_step: physics step [s].
        gravity: [m/s^2] in the world frame.
        solver: 'ode': steps as Gazebo's ODE makes them; or 'bullet': PyBullet's own.
        fixed_joints: 'keep': links on an SDF's fixed joints, and what fixed joints hold in the
            world, are bodies on joints, as in Gazebo; 'merge': they are parts of each other, and
            of the world, as with 'bullet'.
        massless_links: of URDFs: 'leave_out' or 'keep', see formats.urdf.parse_urdf.

    Attributes:
        on_implausible: function of a message, called once for each model whose state is
            implausible, see implausible_state().
        stepper: makes each step in the engine's place, by a call of its step() that something
            comes before and after; None: nothing does.
        is_shown: it is as after a recorded step, see show().
        stepper_is_idle: function that tells whether it may make several steps in a call.

    Raises:
        ModelError: no such solver, fixed_joints or massless_links, or 'ode' cannot be loaded.
    """

    def __init__(
        self,
        time_step: float = DEFAULT_STEP,
        gravity: Vec3 = (0.0, 0.0, -9.81),
        solver: str = "ode",
        fixed_joints: str = "keep",
        massless_links: str = LEAVE_OUT,
    ) -> None:
        check_massless(massless_links)
        self.massless_links = massless_links
        self.engine: Engine = make_engine(solver, time_step, gravity, fixed_joints)
        self._folder = OwnFolder()  # of the models' prepared files
        self._next_key = 0
        self.name = "default"
        self.scene = Scene()
        self.place = Place()  # on the earth
        self.wind: WindForces | None = None
        self.models: dict[str, Model] = {}
        self._driven: tuple[Model, ...] | None = None  # see _driven_models()
        self.forces = Forces()
        self.on_implausible: Callable[[str], None] = lambda message: None
        self.stepper: Callable[..., Array | None] | None = None
        self.stepper_is_idle: Callable[[], bool] = lambda: False
        self._recorded = 0, 0  # first and last step
        self.is_shown = False  # a recorded step, see show()
        self._reported: set[str] = set()  # models that are in an implausible state
        self.step_count = 0
        self._next_check = 0.0  # simulated time of the next check for implausible states
        self._order = ModelOrder()
        self._visible: Any = None  # a VisibleScene, once it is wanted

    @property
    def time_step(self) -> float:
        """Physics step [s]."""
        return self.engine.time_step

    @property
    def gravity(self) -> Vec3:
        """Gravity [m/s^2] in the world frame."""
        return self.engine.gravity

    @property
    def visible(self) -> Any:
        """What lidars of the type gpu_ray see, with the rays of an Engine: the visuals; with the
        solver 'bullet' what collides."""
        if self._visible is None:
            self._visible = VisibleScene(self)
        return self.engine if self.engine.settings is None else self._visible

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.step_count * self.engine.time_step

    def set_time_step(self, time_step: float) -> None:
        """Change the physics step [s] between two steps.

        Simulated time stays, or goes on to the next multiple of the new step. Wrenches and efforts
        keep their times.

        Raises:
            WorldError: out of bounds.
        """
        if not MIN_STEP <= time_step < 1:
            raise WorldError(f"time_step is {time_step} s, must be from {MIN_STEP:g} to below 1")
        before, count = self.time_step, self.step_count
        self.step_count = math.ceil(self.time / time_step - 1e-6)
        self.forces.rescale(count, self.step_count, before / time_step)
        self.engine.set_time_step(time_step)

    def close(self) -> None:
        """Free the engine and the temporary files."""
        self.engine.close()
        self._folder.close()

    def load(self, described: WorldDescription) -> list[str]:
        """Load a WorldDescription: gravity, step and models.

        Returns:
            Warnings (ReadWarning), one message each; a model that cannot be loaded is one.
        """
        self.name, self.scene, self.place = described.name, described.scene, described.place
        self.wind = (
            None
            if described.wind is None
            else WindForces(lambda: self.models.values(), described.wind)
        )
        self.engine.set_gravity(described.gravity)
        self.engine.configure(described.ode)
        self.engine.set_time_step(described.step)
        self.step_count = math.ceil(described.time / described.step - 1e-6)
        for model, pose in described.models:
            try:
                self.spawn(model, pose)
            except ModelError as error:
                described.warn(f"{error}; it is left out", "models are left out", f"'{model.name}'")
            else:
                if model.name in described.starts:
                    self.models[model.name].set_state(described.starts[model.name])
                for link, motion in described.motions.get(model.name, {}).items():
                    self._start(self.models[model.name], link, motion)
            for warning in list(model.warnings):
                described.warnings.add(warning, warning.cause, warning.item)
        names = (model.name for model, _ in described.models)
        self._order.of_file += tuple(name for name in names if name in self.models)
        return list(described.warnings)

    def _start(self, model: Model, link: str, motion: LinkMotion) -> None:
        """Have a link start as a <state> says; links that are merged into others start as these."""
        if model.is_static or link not in model.link_names or model.link_in_body(link)[0] != link:
            return
        steps = self.step_count, self.step_count + 1
        try:
            if any((*motion.linear, *motion.angular)):
                pose = model.link_state(link)[0]
                model.set_link_state(link, pose, motion.linear, motion.angular)
            self.forces.apply_wrench(model, link, motion.force, motion.torque, steps)
        except SimError as error:
            model.description.warn(f"{error}; it starts at rest", "links start at rest", link)

    def spawn_urdf(
        self, name: str, text: str | bytes | Node, pose: Pose, resolve: Resolve
    ) -> Model:
        """Spawn a robot from URDF text; returns the Model (see its description.warnings).

        The <origin> of its <robot> applies within the given pose, as by gazebo_ros.
        """
        description = urdf.parse_urdf(text, resolve, name, self.massless_links)
        return self.spawn(description, pose * description.origin)

    def spawn_sdf(self, name: str, text: str | bytes | Node, pose: Pose, resolve: Resolve) -> Model:
        """Spawn an SDF model; its own <pose> applies within the given one.

        A text whose <world> has no <include> keeps the name of its first model.
        """
        description, model_pose = sdf.parse_model(text, resolve, f"SDF of '{name}'", name)
        return self.spawn(description, pose * model_pose)

    def prepare(self, description: ModelDescription) -> None:
        """Convert the meshes and images of a model that is to be spawned; of any thread."""
        if description.motion is None:
            with contextlib.suppress(OSError, SimError):  # of which spawn() tells
                lumped = self.engine.lump(description)
                prepare_meshes(lumped, self._folder.path, lambda *_: None)

    def spawn(self, description: ModelDescription, pose: Pose = Pose()) -> Model:
        """Spawn a ModelDescription with its root link's frame at a world pose.

        Raises:
            ModelError: the name is taken or empty, the pose is out of bounds, or it does not load.
        """
        name, folder = description.name, self._folder.path
        if not name:
            raise ModelError("a model needs a name, this one is empty")
        if name in self.models:
            raise ModelError(f"model '{name}' exists already; models are {', '.join(self.models)}")
        if not pose.is_placeable():
            raise ModelError(
                f"pose of '{name}' is {pose.position}, {pose.orientation}; {PLACEABLE}"
            )
        self._next_key += 1
        arguments = self._next_key, description, pose.normalized(), folder, lambda: self.time
        try:
            model = Model(self.engine, *arguments)
        except OSError as error:  # the disk is full, or the folder was removed
            raise ModelError(
                f"'{name}' cannot be prepared in {folder}: {error.strerror or error}"
            ) from error
        self.models[name], self._driven = model, None
        self._order.changed = True
        return model

    def model(self, name: str) -> Model:
        """The model of that name.

        Raises:
            WorldError: there is none.
        """
        if name not in self.models:
            raise WorldError(
                f"model '{name}' does not exist; models are {', '.join(self.models) or '(none)'}"
            )
        return self.models[name]

    def delete(self, name: str) -> None:
        """Remove a model."""
        self.forces.remove_model(self.model(name))
        self._reported.discard(name)
        self.model(name).remove()
        del self.models[name]
        self._driven = None
        self._order.changed = self._order.deleted = True

    def attach(self, key: Any, model: str, link: str, other: str, other_link: str) -> None:
        """Hold a link of a model where it is now relative to one of another, see Engine.attach().

        Args:
            key: of Engine.attach().

        Raises:
            WorldError, ModelError: there is no such model, or link.
        """
        one, two = self.model(model), self.model(other)
        for each in (one, two):
            if each.body.number < 0:
                raise WorldError(f"'{each.name}' is an actor, which cannot be attached")
        first, second = one.link_in_body(link)[0], two.link_in_body(other_link)[0]
        self.engine.attach(key, (one.body.number, first), (two.body.number, second))

    @property
    def most_recorded(self) -> int:
        """Steps that can be recorded at most; 0: none."""
        records = self.engine.records
        return 0 if records is None or self.stepper else records.most

    @property
    def makes_steps_at_once(self) -> bool:
        """Whether step() is one call of the engine: nothing acts between its steps."""
        acting = self._driven_models() or self.wind or self.forces.active or self.stepper
        return not acting

    def step(self, count: int = 1, records: bool = False) -> None:
        """Advance by `count` time steps; before each, periodic controllers and forces act.

        The engine makes as many in one call as there are until something has to be updated.

        Args:
            records: record the states of these steps for show(), at most `most_recorded`.
        """
        recorder = self.engine.records if records else None
        if recorder is None:
            self._step(count)
            return
        recorder.begin()
        first = self.step_count + 1
        try:
            self._step(count)
        finally:
            recorder.end(self.step_count - first + 1)
            self._recorded = first, self.step_count

    def times(self, steps: Sequence[int]) -> list[float]:
        """Times [s] after steps."""
        step = self.time_step
        return [count * step for count in steps]

    def recorded(self, steps: Sequence[int]) -> slice | list[int]:
        """Indices of recorded steps, in their order, among all that are recorded."""
        first, last = steps[0] - self._recorded[0], steps[-1] - self._recorded[0]
        if last - first + 1 == len(steps):
            return slice(first, last + 1)
        return [step - self._recorded[0] for step in steps]

    def show(self, step: int) -> None:
        """Be as after a recorded step of the last step(), until show_end(): the time, poses,
        velocities, joints. What reads these alone then reads what it would have read.

        Args:
            step: its step_count.
        """
        assert self.engine.records is not None
        self.engine.records.show(step - self._recorded[0])
        self.step_count, self.is_shown = step, True

    def show_contacts(self, step: int) -> None:
        """As show(), for contacts alone, of links that record them: api.Body.records_contacts()."""
        assert self.engine.records is not None
        self.engine.records.show_contacts(step - self._recorded[0])

    def show_end(self) -> None:
        """Be as after the last step."""
        assert self.engine.records is not None
        self.engine.records.show_end()
        self.step_count, self.is_shown = self._recorded[1], False

    def _driven_models(self) -> tuple[Model, ...]:
        """Models that have controllers or joints that mimic others."""
        if self._driven is None:
            models = self.models.values()
            self._driven = tuple(each for each in models if each.manager is not None or each.mimics)
        return self._driven

    def _step(self, count: int) -> None:
        driven = self._driven_models()
        controlled = [
            (model, model.manager)
            for model in driven
            if model.manager is not None and model.manager.periodic
        ]
        updates: list[Callable[[float], None]] = [
            model.mimics.update for model in driven if model.mimics
        ]
        wind = self.wind
        if wind is not None:
            updates.append(lambda period: wind.update(self.time + period, period))
        engine, forces, time_step = self.engine, self.forces, self.time_step
        advance = self.stepper or engine.step
        end = self.step_count + count
        while self.step_count < end:
            steps = end - self.step_count
            for _, manager in controlled:
                steps = min(steps, manager.prepare_steps(time_step))
            if updates or forces.active or (self.stepper and not self.stepper_is_idle()):
                steps = 1
                for update in updates:
                    update(time_step)
                if forces.active:
                    forces.apply(self.step_count)
            if not controlled:
                advance(steps)
                self.step_count += steps
                continue
            records = any(manager.computes for _, manager in controlled)
            steps = min(steps, MAX_RECORDED) if records else steps
            efforts = [row for _, manager in controlled for row in manager.efforts]
            recorded = advance(steps, efforts, records)
            self.step_count += steps
            for model, manager in controlled:
                rows = None
                if recorded is not None and manager.computes:
                    columns = engine.joint_columns(model.body, model.joints.names)
                    rows = recorded[:, :, columns]
                manager.finish_steps(steps, time_step, rows)
        self._order.fresh = False  # from now on models stay as they were loaded
        if self.time >= self._next_check:
            self._next_check = self.time + PERIOD
            self._check()

    def _check(self) -> None:
        """Tell once of each model with an implausible state."""
        for name, model in self.models.items():
            if name not in self._reported and not model.is_static:
                text = implausible_state(model)
                if text is not None:
                    self._reported.add(name)
                    self.on_implausible(text)

    def reset(self, time: bool = True) -> None:
        """Reload every model at its initial pose into a cleared engine, as after a new start.

        Args:
            time: also set simulated time to 0.
        """
        self.forces.clear()
        if self.wind is not None:
            self.wind.restart()
        self._reload()
        self._next_check = 0.0
        self._order.reset()
        if time:
            self.step_count = 0

    def start_over(self, time: bool = True) -> None:
        """Put every model to its initial pose, at rest, and its joints to theirs, as
        /gazebo/reset_simulation does.

        Controllers, their commands, wrenches and efforts go on; those that have a begin or an end
        in simulated time keep it. Where a model's state is implausible all are loaded again.

        Args:
            time: also set simulated time to 0.
        """
        if self._reported:
            forces = self.forces.get_state()
            self.reset(time)
            self.forces.set_state(forces)
            return
        self._next_check = 0.0
        before = self.time
        if time:
            self.step_count = 0
        for model in self.models.values():
            model.put_back(self.time, with_joints=True, by=before - self.time)

    def reset_models(self) -> None:
        """Put every model to its initial pose, at rest, as /gazebo/reset_world does.

        Joints stay where they are. Time, wrenches, commands and controllers go on; for controllers
        the next update has the period since the start of time, as gazebo_ros_control has it then.
        """
        for model in self.models.values():
            model.put_back(self.time)

    def sort_models(self) -> bool:
        """Sort the models: those of the world file in file order, then the others by name.

        A reset retains the order (see ModelOrder).

        Returns:
            Whether the order has changed.
        """
        ordered = self._order.sorted(self.models)
        changed = ordered != list(self.models)
        self.models, self._driven = {name: self.models[name] for name in ordered}, None
        return changed

    def sort_before_start(self) -> bool:
        """Before the first step: make the results independent of the order of spawning.

        If the models were spawned in another order than that of `sort_models`, or some were
        deleted, all are reloaded in that order; poses and joint positions set since then stay.
        Controllers restart, so it has to be called before commands are applied.

        Returns:
            Whether models were reloaded.
        """
        order = self._order
        if not (order.fresh and order.changed):
            return False
        deleted = order.deleted
        order.changed = order.deleted = False
        if not (self.sort_models() or deleted):
            return False
        saved = [model.save_state() for model in self.models.values()]
        owners = {model.body.number: model for model in self.models.values()}
        held = [
            (key, [(owners[body], link) for body, link in pair])
            for key, pair in self.engine.attachments().items()
        ]
        self._reload()
        for model, state in zip(self.models.values(), saved):
            model.restore_state(state)
        for key, pair in held:
            one, other = ((model.body.number, link) for model, link in pair)
            self.engine.attach(key, one, other)
        return True

    def _reload(self) -> None:
        """Load all models into a cleared engine, at their initial poses."""
        self.engine.clear()
        self._reported.clear()
        for model in self.models.values():
            model.reload()

    def save_state(self) -> WorldState:
        """Save bodies, joints, controllers, forces and the time.

        Where links of several collision shapes touch something, this clears the contacts, also for
        the world that goes on.
        """
        models = self.models.values()
        return WorldState(
            dict(self.models),
            _bodies(self.models),
            tuple(_controllers(model) for model in models),
            self.engine.save_state(),
            tuple(part.get_state() for part in self._parts()),
            tuple(model.placed for model in models),
            self.time_step,
            self.step_count,
            self._next_check,
        )

    def _parts(self) -> list[Stateful]:
        """What has a state besides the bodies: forces, order, joints and controllers."""
        parts: list[Stateful] = [self.forces, self._order]
        parts += [self.wind] if self.wind is not None else []
        for model in self.models.values():
            parts.append(model.mimics)
            if model.manager is not None:
                parts.append(model.manager)
        return parts

    def restore_state(self, state: WorldState) -> str:
        """Go back to a saved state; what follows is bit-identical to what followed then.

        Properties (masses, gravity, lights) stay as they are now.

        Returns:
            What is not as it was, one message, or ''.

        Raises:
            WorldError: models or controllers came or went since; nothing has changed then.
        """
        self._check_state(state)
        self.models, self._driven = dict(state.models), None
        known = state.engine.is_cleared or self.engine.layout == state.engine.layout
        if _bodies(self.models) != state.bodies or not known and _are_first(state.bodies):
            self._reload()
        for part, saved in zip(self._parts(), state.parts):  # of the same models, see _check_state
            part.set_state(saved)
        same = self.engine.restore_state(state.engine)
        for model, placed in zip(state.models.values(), state.placed):
            model.placed = placed
        self.step_count, self._next_check = state.step_count, state.next_check
        return "" if same else COLD

    def _check_state(self, state: WorldState) -> None:
        """Raise WorldError for a state that the world cannot return to."""
        for name, model in state.models.items():
            if name not in self.models:
                raise WorldError(f"the state has the model '{name}', which was deleted since")
            if self.models[name] is not model:
                raise WorldError(
                    f"model '{name}' was deleted and spawned again since the state was saved"
                )
        for name in self.models:
            if name not in state.models:
                raise WorldError(f"model '{name}' was spawned since the state was saved; delete it")
        for model, loaded in zip(state.models.values(), state.controllers):
            present = _controllers(model)
            if present != loaded:
                raise WorldError(
                    f"controllers of '{model.name}' were loaded or unloaded since the state was "
                    f"saved; they were {_names(loaded)} and are {_names(present)}"
                )
        if self.time_step != state.time_step:
            raise WorldError(
                f"the physics step is {self.time_step:g} s, and was {state.time_step:g} s when "
                "the state was saved"
            )
        if _bodies(state.models) != state.bodies and not _are_first(state.bodies):
            raise WorldError(
                "models had been deleted before the state was saved, and the world was reset "
                "since; save a new state"
            )

    def sources(self) -> list[BodySource]:
        """BodySources of all models, for a mirror."""
        return [model.source for model in self.models.values()]

    def snapshot(self) -> Snapshot:
        """The state of all bodies now."""
        return Snapshot(
            self.time, self.step_count, tuple(model.state() for model in self.models.values())
        )
