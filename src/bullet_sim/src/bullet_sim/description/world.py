"""What a world file says: gravity, step and models; the worlds that need no file."""

from dataclasses import dataclass, field

from bullet_sim.description.lights import Scene
from bullet_sim.description.parts import Geometry, Link, ModelDescription, Shape
from bullet_sim.description.read_warning import add_warning
from bullet_sim.pose import Pose

GROUND_COLOR = (0.6, 0.6, 0.6, 1.0)
MIN_STEP = 1e-6  # [s] shortest physics step
DEFAULT_STEP = 0.001  # [s]


@dataclass
class WorldDescription:
    """Contents of a world file; models with their world poses, in file order.

    Attributes:
        gravity: [m/s^2].
        step: of the physics [s].
        real_time_factor: simulated seconds per wall second that the file asks for; 0: as fast
            as possible.
        scene: lights, background and fog.
        warnings: what was ignored or mended, with that of the models in its file.
    """

    name: str = "default"
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    step: float = DEFAULT_STEP
    real_time_factor: float = 1.0
    models: list[tuple[ModelDescription, Pose]] = field(default_factory=list)
    scene: Scene = Scene()
    warnings: list[str] = field(default_factory=list)

    def warn(self, text, cause="", item=""):
        """Note something that was ignored or mended, once: see ReadWarning."""
        add_warning(self.warnings, text, cause, item)


def ground_plane():
    """The built-in endless floor at z = 0, friction 1."""
    model = ModelDescription("ground_plane", root="link", static=True)
    link = Link("link")
    link.surface.friction = 1.0
    link.collisions.append(Shape(Geometry("plane"), name="collision", link="link"))
    link.visuals.append(
        Shape(
            Geometry("box", (100.0, 100.0, 0.002)),
            Pose((0.0, 0.0, -0.003)),
            GROUND_COLOR,
            name="visual",
            link="link",
        )
    )
    model.links["link"] = link
    return model


def empty_world():
    """The WorldDescription of Gazebo's empty world: the floor and the sun."""
    return WorldDescription(models=[(ground_plane(), Pose())])
