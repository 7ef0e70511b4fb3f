"""The world: models in an engine, simulated time, spawn, delete, reset, snapshots."""

import shutil
import tempfile

from bullet_sim.description.read_warning import add_warning
from bullet_sim.engine import Engine
from bullet_sim.errors import ModelError, WorldError
from bullet_sim.formats import urdf
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.models.forces import Forces
from bullet_sim.models.model import Model
from bullet_sim.pose import PLACEABLE, Pose
from bullet_sim.snapshot import Snapshot


class World:
    """Everything that is simulated.

    Args:
        time_step: physics step [s].
        gravity: [m/s^2] in the world frame.
        engine: an Engine to use instead of a new one (tests).
    """

    def __init__(self, time_step=0.001, gravity=(0.0, 0.0, -9.81), engine=None):
        self._engine = engine or Engine(time_step, gravity)
        self._folder = tempfile.mkdtemp(prefix="bullet_sim_")
        self._next_key = 0
        self.name = "default"
        self.models = {}
        self.forces = Forces()
        self.step_count = 0
        self._loaded_names = ()  # models of the world file, in its order
        self._fresh = True  # no step yet since the start or the last reset
        self._unsettled = self._holes = False  # models came or went, some went, since then

    @property
    def time_step(self):
        """Physics step [s]."""
        return self._engine.time_step

    @property
    def gravity(self):
        """Gravity [m/s^2] in the world frame."""
        return self._engine.gravity

    @property
    def time(self):
        """Simulated time [s]."""
        return self.step_count * self._engine.time_step

    @property
    def engine(self):
        """The engine, for sensors that cast rays."""
        return self._engine

    def set_time_step(self, time_step):
        """Change the physics step [s] between two steps; simulated time stays.

        Raises:
            WorldError: out of bounds, or something counts in steps of the present length.
        """
        if not sdf.MIN_STEP <= time_step < 1:
            raise WorldError(
                f"time_step is {time_step} s, must be from {sdf.MIN_STEP:g} to below 1"
            )
        busy = [
            name
            for name, model in self.models.items()
            if model.manager is not None or model.description.sensors
        ]
        if busy:
            raise WorldError(
                f"time_step cannot change while models with controllers or sensors "
                f"exist, their periods count in steps: {', '.join(busy)}"
            )
        if self.forces.active:
            raise WorldError(
                "time_step cannot change while a wrench or an effort is applied; clear it first"
            )
        self.step_count = round(self.time / time_step)
        self._engine.set_time_step(time_step)

    def close(self):
        """Free the engine and the temporary files."""
        self._engine.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def load(self, described):
        """Take over a WorldDescription: gravity, step and models.

        Returns:
            Warnings (ReadWarning), one sentence each; a model that cannot be loaded is one.
        """
        self.name = described.name
        self._engine.set_gravity(described.gravity)
        self._engine.set_time_step(described.step)
        warnings = described.warnings
        for model, pose in described.models:
            try:
                self.spawn(model, pose)
            except ModelError as error:
                described.warn(f"{error}; it is left out", "models are left out", f"'{model.name}'")
            for warning in list(model.warnings):
                add_warning(warnings, warning, warning.cause, warning.item)
        self._loaded_names += tuple(
            model.name for model, _ in described.models if model.name in self.models
        )
        return list(warnings)

    def spawn_urdf(self, name, text, pose, resolve):
        """Spawn a robot from URDF text (or its root); returns the Model (see its description)."""
        return self.spawn(urdf.parse_urdf(text, resolve, name), pose)

    def spawn_sdf(self, name, text, pose, resolve):
        """Spawn an SDF model from text (or its root); its own <pose> applies within the given."""
        description, own = sdf.parse_model(text, resolve, f"SDF of '{name}'")
        description.name = name
        return self.spawn(description, pose * own)

    def spawn(self, description, pose=Pose()):
        """Spawn a ModelDescription with its root link's frame at a world pose.

        Raises:
            ModelError: the name is taken or empty, the pose is out of bounds, or it does not load.
        """
        if not description.name:
            raise ModelError("a model needs a name, this one is empty")
        if description.name in self.models:
            raise ModelError(
                f"model '{description.name}' exists already; models are {', '.join(self.models)}"
            )
        if not pose.is_placeable():
            raise ModelError(
                f"pose of '{description.name}' is {pose.position}, {pose.orientation}; {PLACEABLE}"
            )
        self._next_key += 1
        model = Model(self._engine, self._next_key, description, pose.normalised(), self._folder)
        self.models[description.name] = model
        self._unsettled = True
        return model

    def model(self, name):
        """The model of that name.

        Raises:
            WorldError: there is none.
        """
        if name not in self.models:
            raise WorldError(
                f"model '{name}' does not exist; models are {', '.join(self.models) or '(none)'}"
            )
        return self.models[name]

    def delete(self, name):
        """Remove a model."""
        self.forces.forget(self.model(name))
        self.model(name).remove()
        del self.models[name]
        self._unsettled = self._holes = True

    def step(self, count=1):
        """Advance by `count` time steps; before each, periodic controllers and forces act."""
        managers = [
            model.manager
            for model in self.models.values()
            if model.manager is not None and model.manager.periodic
        ]
        if not managers and not self.forces.active:
            self._engine.step(count)
            self.step_count += count
            self._fresh = False
            return
        for _ in range(count):
            for manager in managers:
                manager.update(self.time_step)
            if self.forces.active:
                self.forces.apply(self.step_count)
            self._engine.step()
            self.step_count += 1
        self._fresh = False

    def reset(self, time=True):
        """Reload every model at its initial pose into a cleared engine: as a fresh start.

        Args:
            time: also set simulated time to 0.
        """
        self.forces.clear()
        self._engine.clear()
        for model in self.models.values():
            model.reload()
        self._fresh, self._unsettled, self._holes = True, False, False
        if time:
            self.step_count = 0

    def arrange(self):
        """Order the models: those of the world file as it lists them, then the others by name.

        The engine's results depend, in the last bits, on the order in which bodies were loaded;
        programs that spawn at the same time do it in any order. A reset keeps the order.

        Returns:
            Whether anything changed its place.
        """
        first = {name: number for number, name in enumerate(self._loaded_names)}
        ordered = sorted(self.models, key=lambda name: (first.get(name, len(first)), name))
        changed = ordered != list(self.models)
        self.models = {name: self.models[name] for name in ordered}
        return changed

    def settle(self):
        """Before the first step: make what follows independent of the order of spawning.

        Loads the models anew in the order of `arrange` where they were spawned in another one or
        some were deleted again; poses and joint positions that were set meanwhile stay.
        Controllers restart, so call it before commands are handed over.

        Returns:
            Whether models were loaded anew.
        """
        if not (self._fresh and self._unsettled):
            return False
        self._unsettled = False
        if not self.arrange() and not self._holes:
            return False
        self._holes = False
        kept = [model.placement() for model in self.models.values()]
        self._engine.clear()
        for model, placement in zip(self.models.values(), kept):
            model.reload()
            model.place(placement)
        return True

    def sources(self):
        """BodySources of all models, for a mirror."""
        return [model.source for model in self.models.values()]

    def snapshot(self):
        """The state of all bodies now."""
        return Snapshot(
            self.time, self.step_count, tuple(model.state() for model in self.models.values())
        )
