"""From descriptions to models: a world file's, and one model's."""

from collections.abc import Callable

from bullet_sim.description.parts import ModelDescription
from bullet_sim.description.read_warning import add_warning
from bullet_sim.description.world import WorldDescription
from bullet_sim.engine import Engine
from bullet_sim.errors import ModelError
from bullet_sim.models.model import Model
from bullet_sim.pose import PLACEABLE, Pose
from bullet_sim.system.folders import OwnFolder

Spawn = Callable[[ModelDescription, Pose], Model]


class Loader:
    """Makes Models in an engine; their prepared files are in a temporary folder.

    Args:
        engine: Engine.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._folder = OwnFolder()
        self._next_key = 0

    def load(self, description: ModelDescription, pose: Pose) -> Model:
        """A new Model with its root link's frame at a world pose.

        Raises:
            ModelError: the pose is out of bounds, or it does not load.
        """
        if not pose.is_placeable():
            raise ModelError(
                f"pose of '{description.name}' is {pose.position}, {pose.orientation}; {PLACEABLE}"
            )
        self._next_key += 1
        folder = self._folder.path
        try:
            return Model(self._engine, self._next_key, description, pose.normalised(), folder)
        except OSError as error:  # the disk is full, or somebody has removed the folder
            raise ModelError(
                f"'{description.name}' cannot be prepared in {folder}: {error.strerror or error}"
            ) from error

    def close(self) -> None:
        """Remove the folder."""
        self._folder.close()


def spawn_all(
    described: WorldDescription, spawn: Callable[[ModelDescription, Pose], Model]
) -> None:
    """Spawn a world file's models; what is wrong with one goes to the world's warnings.

    Args:
        described: WorldDescription.
        spawn: World.spawn, or the like.
    """
    for model, pose in described.models:
        try:
            spawn(model, pose)
        except ModelError as error:
            described.warn(f"{error}; it is left out", "models are left out", f"'{model.name}'")
        for warning in list(model.warnings):
            add_warning(described.warnings, warning, warning.cause, warning.item)
