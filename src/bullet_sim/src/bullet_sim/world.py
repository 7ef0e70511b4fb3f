"""The world: models in an engine, simulated time, spawn, delete, reset, snapshots."""

import shutil
import tempfile

from bullet_sim import sdf, urdf
from bullet_sim.engine import Engine
from bullet_sim.errors import ModelError, WorldError
from bullet_sim.model import Model
from bullet_sim.pose import Pose
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
        self._folder = tempfile.mkdtemp(prefix='bullet_sim_')
        self._next_key = 0
        self.name = 'default'
        self.models = {}
        self.step_count = 0

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

    def close(self):
        """Free the engine and the temporary files."""
        self._engine.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def load(self, described):
        """Take over a WorldDescription: gravity, step and models.

        Returns:
            Warnings, one sentence each.
        """
        self.name = described.name
        self._engine.set_gravity(described.gravity)
        self._engine.set_time_step(described.step)
        warnings = list(described.warnings)
        for model, pose in described.models:
            self.spawn(model, pose)
            warnings += model.warnings
        return warnings

    def spawn_urdf(self, name, text, pose, resolve):
        """Spawn a robot from URDF text; returns the Model (see its description.warnings)."""
        return self.spawn(urdf.parse_urdf(text, resolve, name), pose)

    def spawn_sdf(self, name, text, pose, resolve):
        """Spawn an SDF model; its own <pose> applies within the given one."""
        description, own = sdf.parse_model(text, resolve, f"SDF of '{name}'")
        description.name = name
        return self.spawn(description, pose * own)

    def spawn(self, description, pose=Pose()):
        """Spawn a ModelDescription with its root link's frame at a world pose.

        Raises:
            ModelError: the name is taken or empty, the pose is not finite, or it does not load.
        """
        if not description.name:
            raise ModelError('a model needs a name, this one is empty')
        if description.name in self.models:
            raise ModelError(f"model '{description.name}' exists already; models are "
                             f"{', '.join(self.models)}")
        if not pose.is_finite():
            raise ModelError(f"pose of '{description.name}' is {pose.position}, "
                             f'{pose.orientation}; must be finite')
        self._next_key += 1
        model = Model(self._engine, self._next_key, description, pose.normalised(),
                      self._folder)
        self.models[description.name] = model
        return model

    def model(self, name):
        """The model of that name.

        Raises:
            WorldError: there is none.
        """
        if name not in self.models:
            raise WorldError(f"model '{name}' does not exist; models are "
                             f"{', '.join(self.models) or '(none)'}")
        return self.models[name]

    def delete(self, name):
        """Remove a model."""
        self.model(name).remove()
        del self.models[name]

    def step(self, count=1):
        """Advance by `count` time steps; periodic controllers are updated before each."""
        managers = [model.manager for model in self.models.values()
                    if model.manager is not None and model.manager.periodic]
        if not managers:
            self._engine.step(count)
            self.step_count += count
            return
        for _ in range(count):
            for manager in managers:
                manager.update(self.time_step)
            self._engine.step()
            self.step_count += 1

    def reset(self, time=True):
        """Reload every model at its initial pose into a cleared engine: as a fresh start.

        Args:
            time: also set simulated time to 0.
        """
        self._engine.clear()
        for model in self.models.values():
            model.reload()
        if time:
            self.step_count = 0

    def sources(self):
        """BodySources of all models, for a mirror."""
        return [model.source for model in self.models.values()]

    def snapshot(self):
        """The state of all bodies now."""
        return Snapshot(self.time, self.step_count,
                        tuple(model.state() for model in self.models.values()))
