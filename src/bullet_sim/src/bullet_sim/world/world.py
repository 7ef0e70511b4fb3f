"""The world: models in an engine, simulated time, spawn, delete, reset, snapshots."""

from collections.abc import Callable

from bullet_sim.description.lights import Scene
from bullet_sim.description.parts import ModelDescription
from bullet_sim.description.world import WorldDescription
from bullet_sim.engine import Engine
from bullet_sim.errors import WorldError
from bullet_sim.formats import urdf
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.models.contacts import Contacts
from bullet_sim.models.forces import Forces
from bullet_sim.models.model import Model
from bullet_sim.models.plausibility import PERIOD
from bullet_sim.pose import Point, Pose
from bullet_sim.snapshot import BodySource, Snapshot
from bullet_sim.world.checks import check_name, check_state, check_time_step
from bullet_sim.world.loading import Loader, spawn_all
from bullet_sim.world.order import ModelOrder, reload_in_place
from bullet_sim.world.state import WorldState, restore, save

Resolve = Callable[[str], str]  # URI -> path


class World:
    """Everything that is simulated.

    Args:
        time_step: physics step [s].
        gravity: [m/s^2] in the world frame.
        engine: an Engine to use instead of a new one (tests).
    """

    def __init__(
        self,
        time_step: float = 0.001,
        gravity: Point = (0.0, 0.0, -9.81),
        engine: Engine | None = None,
    ) -> None:
        self._engine = engine or Engine(time_step, gravity)
        self._loader = Loader(self._engine)
        self.name = "default"
        self.scene = Scene()
        self.models: dict[str, Model] = {}
        self.forces = Forces()
        self.contacts = Contacts(self._engine)
        self.step_count = 0
        self._next_check = 0.0  # simulated time of the next check for implausible states
        self._order = ModelOrder()

    @property
    def time_step(self) -> float:
        """Physics step [s]."""
        return self._engine.time_step

    @property
    def gravity(self) -> Point:
        """Gravity [m/s^2] in the world frame."""
        return self._engine.gravity

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.step_count * self._engine.time_step

    @property
    def engine(self) -> Engine:
        """The engine, for sensors that cast rays."""
        return self._engine

    def set_time_step(self, time_step: float) -> None:
        """Change the physics step [s] between two steps; simulated time stays.

        Raises:
            WorldError: out of bounds, or a period is counted in steps of the present length.
        """
        check_time_step(self, time_step)
        self.step_count = round(self.time / time_step)
        self._engine.set_time_step(time_step)

    def close(self) -> None:
        """Free the engine and the temporary files."""
        self._engine.close()
        self._loader.close()

    def load(self, described: WorldDescription) -> list[str]:
        """Load a WorldDescription: gravity, step and models.

        Returns:
            Warnings (ReadWarning), one sentence each; a model that cannot be loaded is one.
        """
        self.name, self.scene = described.name, described.scene
        self._engine.set_gravity(described.gravity)
        self._engine.set_time_step(described.step)
        spawn_all(described, self.spawn)
        self._order.add_of_file(
            model.name for model, _ in described.models if model.name in self.models
        )
        return list(described.warnings)

    def spawn_urdf(self, name: str, text: str, pose: Pose, resolve: Resolve) -> Model:
        """Spawn a robot from URDF text; returns the Model (see its description.warnings)."""
        return self.spawn(urdf.parse_urdf(text, resolve, name), pose)

    def spawn_sdf(self, name: str, text: str, pose: Pose, resolve: Resolve) -> Model:
        """Spawn an SDF model; its own <pose> applies within the given one."""
        description, model_pose = sdf.parse_model(text, resolve, f"SDF of '{name}'")
        description.name = name
        return self.spawn(description, pose * model_pose)

    def spawn(self, description: ModelDescription, pose: Pose = Pose()) -> Model:
        """Spawn a ModelDescription with its root link's frame at a world pose.

        Raises:
            ModelError: the name is taken or empty, the pose is out of bounds, or it does not load.
        """
        check_name(description.name, self.models)
        model = self._loader.load(description, pose)
        self.models[description.name] = model
        self.contacts.model_added(model)
        model.on_moved = self.contacts.model_moved
        self._order.spawned()
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
        self.contacts.model_removed(self.model(name))
        self.model(name).remove()
        del self.models[name]
        self._order.deleted()

    def step(self, count: int = 1) -> None:
        """Advance by `count` time steps; before each, periodic controllers and forces act."""
        managers = [
            model.manager
            for model in self.models.values()
            if model.manager is not None and model.manager.periodic
        ]
        mimics = [model.mimics for model in self.models.values() if model.mimics]
        self.contacts.prepare(self.models)
        updates = [each.update for each in (*managers, *mimics)]
        engine, forces, time_step = self._engine, self.forces, self.time_step
        contacts = None if self.contacts.is_quiet else self.contacts
        end = self.step_count + count
        while self.step_count < end:
            stride = end - self.step_count
            if updates or forces.active:
                stride = 1
                for update in updates:
                    update(time_step)
                if forces.active:
                    forces.apply(self.step_count)
            if contacts is None:
                engine.step(stride)
                self.step_count += stride
                continue
            stride = contacts.stride(self.step_count, stride)
            contacts.apply_forces()
            engine.step(stride)
            self.step_count += stride
            contacts.update(self.step_count)
        self._order.stepped()
        if self.time >= self._next_check:
            self._next_check = self.time + PERIOD
            self.contacts.check()

    def reset(self, time: bool = True) -> None:
        """Reload every model at its initial pose into a cleared engine, as after a new start.

        Args:
            time: also set simulated time to 0.
        """
        self.forces.clear()
        self._reload()
        self._next_check = 0.0
        self._order.reset()
        if time:
            self.step_count = 0

    def sort_models(self) -> bool:
        """Sort the models: those of the world file in file order, then the others by name.

        A reset keeps the order (see ModelOrder).

        Returns:
            Whether the order has changed.
        """
        ordered = self._order.sorted(self.models)
        changed = ordered != list(self.models)
        self.models = {name: self.models[name] for name in ordered}
        return changed

    def sort_before_start(self) -> bool:
        """Before the first step: make the results independent of the order of spawning.

        If the models were spawned in another order than that of `sort_models`, or some were
        deleted, all are reloaded in that order; poses and joint positions set since then stay.
        Controllers restart, so it has to be called before commands are applied.

        Returns:
            Whether models were reloaded.
        """
        changed, deleted = self._order.take_change()
        if not changed or not (self.sort_models() or deleted):
            return False
        reload_in_place(self.models.values(), self._reload)
        return True

    def _reload(self) -> None:
        """Load all models into a cleared engine, at their initial poses."""
        self._engine.clear()
        self.contacts.clear()
        for model in self.models.values():
            model.reload()
            self.contacts.model_added(model)

    def save_state(self) -> WorldState:
        """Save bodies, joints, controllers, forces and the time.

        Where links of several collision shapes touch something, and while a model is pushed out of
        another, this clears the contacts, also for the world that goes on.
        """
        return save(self, self._order, self._next_check)

    def restore_state(self, state: WorldState) -> str:
        """Go back to a saved state; what follows is equal to the bit to what followed then.

        Properties (masses, gravity, lights) stay as they are now.

        Returns:
            What is not as it was, one sentence, or ''.

        Raises:
            WorldError: models or controllers came or went since; nothing has changed then.
        """
        check_state(self, state)
        note = restore(self, state, self._reload)
        self.step_count, self._next_check = state.step_count, state.next_check
        return note

    def sources(self) -> list[BodySource]:
        """BodySources of all models, for a mirror."""
        return [model.source for model in self.models.values()]

    def snapshot(self) -> Snapshot:
        """The state of all bodies now."""
        return Snapshot(
            self.time, self.step_count, tuple(model.state() for model in self.models.values())
        )
