"""A world's description: models, physics, lights, background and fog."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Tuple

from bullet_sim.description.model import (
    RGB,
    Finish,
    Geometry,
    Light,
    Link,
    ModelDescription,
    Shape,
)
from bullet_sim.description.warnings import Warnings
from bullet_sim.pose import Pose, Vec3


@dataclass(frozen=True)
class Fog:
    """Fog that hides what is far away.

    Attributes:
        kind: 'linear' (from start to end [m]), 'exp' or 'exp2' (with density [1/m]).
        color: RGB 0..1.
    """

    kind: str = "linear"
    color: RGB = (1.0, 1.0, 1.0)
    start: float = 1.0
    end: float = 100.0
    density: float = 1.0


# Gazebo's model://sun.
SUN = Light(
    "sun",
    position=(0.0, 0.0, 10.0),
    direction=(-0.48339, 0.096678, -0.870102),
    diffuse=(0.8, 0.8, 0.8),
    specular=(0.2, 0.2, 0.2),
    reach=1000.0,
    constant=0.9,
    linear=0.01,
    quadratic=0.001,
    cast_shadows=True,
)


Daytime = Tuple[float, float, float]  # of a sky: its time, its sunrise and its sunset [h]


@dataclass(frozen=True)
class Scene:
    """Light and background of a world.

    Attributes:
        ambient: RGB of the ambient light.
        background: RGB behind everything; None: a sky.
        shadows: whether lights that cast shadows do.
        daytime: of the sky.
        roads: Shapes of <road>s, which are seen and touch nothing.
    """

    ambient: RGB = (0.4, 0.4, 0.4)
    background: RGB | None = (0.7, 0.7, 0.7)
    shadows: bool = True
    fog: Fog | None = None
    lights: tuple[Light, ...] = (SUN,)
    daytime: Daytime = (10.0, 6.0, 20.0)
    roads: tuple[Shape, ...] = ()


# Gazebo/Grey, the material of the floor.
GROUND_COLOR = (0.7, 0.7, 0.7, 1.0)
GROUND = Finish(ambient=(0.3,) * 3, specular=(0.01,) * 3, shininess=1.5, cast_shadows=False)
MIN_STEP = 1e-6  # [s] minimum physics step
DEFAULT_STEP = 0.001  # [s]
MAX_CONTACTS = 250  # of a pair of shapes, as in Gazebo


@dataclass(frozen=True)
class OdeSettings:
    """What a world's <physics> says of ODE's quick solver; the defaults are sdformat's.

    Attributes:
        iterations: per step.
        relaxation: factor of each correction (sor).
        cfm: constraint force mixing of joints [s/kg].
        erp: fraction of a joint's error that is corrected in a step.
        max_speed: at which contacts push bodies apart, at most [m/s].
        max_contacts: of a pair of shapes; above MAX_CONTACTS it counts as that.
        surface_layer: depth of contacts where no body has one of its own, which all have [m].
        precon_iterations: those before; no step makes any.
        evens_inertias: inertias of hinged bodies are at most 200:1 (use_dynamic_moi_rescaling).
        island_threads: that solve bodies which do not touch; 0 or 1: none but that of the steps.
    """

    iterations: int = 50
    relaxation: float = 1.3
    cfm: float = 0.0
    erp: float = 0.2
    max_speed: float = 100.0
    evens_inertias: bool = False
    max_contacts: int = 20
    surface_layer: float = 0.001
    precon_iterations: int = 0
    island_threads: int = 0


@dataclass(frozen=True)
class Place:
    """Where a world is on the earth, its <spherical_coordinates>.

    Attributes:
        latitude, longitude: of its origin [degrees].
        altitude: of its origin [m].
        heading: of its x axis [rad], clockwise from north.
    """

    latitude: float = 0.0
    longitude: float = 0.0
    altitude: float = 0.0
    heading: float = math.pi / 2.0


@dataclass(frozen=True)
class LinkMotion:
    """How a link starts where a <state> says so, world axes.

    Attributes:
        linear, angular: velocity of its center of mass [m/s, rad/s].
        force, torque: that act on it in the first step [N, N m].
    """

    linear: Vec3
    angular: Vec3
    force: Vec3
    torque: Vec3


@dataclass(frozen=True)
class Wind:
    """Of Gazebo's WindPlugin; times are characteristic ones, after which a mean is there by 63 %.

    Attributes:
        velocity: of the world [m/s].
        factor: force on a link by its mass and its velocity in the wind [1/s].
        rise, vertical_rise: of the horizontal and of the vertical speed [s].
        gusts, gust_period: amplitude, a fraction of the speed, and period of its changes [s].
        turn: of its direction [s].
        sway, sway_period: amplitude [degrees] and period [s] of its changes.
        noise: (mean, standard deviation) of the horizontal speed [m/s], of the direction [degrees]
            and of the vertical speed [m/s].
    """

    velocity: Vec3
    factor: float
    rise: float = 1.0
    gusts: float = 0.0
    gust_period: float = 1.0
    turn: float = 1.0
    sway: float = 0.0
    sway_period: float = 1.0
    vertical_rise: float = 1.0
    noise: tuple[tuple[float, float], ...] = ((0.0, 0.0),) * 3


@dataclass
class WorldDescription:
    """Contents of a world file; models with their world poses, in file order.

    Attributes:
        ode: settings of the solver 'ode'.
        gravity: [m/s^2].
        place: on the earth.
        step: of the physics [s].
        real_time_factor: simulated seconds per wall second that the file asks for; 0: as fast
            as possible.
        time: simulated time of its <state> [s], at which it starts; a reset sets it to 0.
        starts: by the names of models: the poses of its <state>, where they start; a reset puts
            them to those of `models`, as in Gazebo.
        motions: by the names of models and of their links: how these start, but for those at rest.
        plugins: names of libraries of its plugins that are known here.
        cpp_plugins: its plugins in C++ (plugins.cpp.CppSpec), in their order.
        wind: that a plugin makes of its <wind>; None: nothing feels it.
        warnings: what was ignored or repaired, also in the models of its file.
    """

    name: str = "default"
    ode: OdeSettings = OdeSettings()
    gravity: Vec3 = (0.0, 0.0, -9.81)
    place: Place = Place()
    step: float = DEFAULT_STEP
    real_time_factor: float = 1.0
    models: list[tuple[ModelDescription, Pose]] = field(default_factory=list)
    scene: Scene = Scene()
    time: float = 0.0
    starts: dict[str, Pose] = field(default_factory=dict)
    motions: dict[str, dict[str, LinkMotion]] = field(default_factory=dict)
    plugins: list[str] = field(default_factory=list)
    cpp_plugins: list[Any] = field(default_factory=list)
    wind: Wind | None = None
    warnings: Warnings = field(default_factory=Warnings)

    def warn(self, text: str, cause: str = "", item: str = "") -> None:
        """Add a warning about something ignored or repaired, once: see ReadWarning."""
        self.warnings.add(text, cause, item)


def ground_plane() -> ModelDescription:
    """The built-in endless floor at z = 0; mu and mu2 of Gazebo's model: a wheel's own count."""
    model = ModelDescription("ground_plane", root="link", static=True)
    link = Link("link")
    link.surface.friction, link.surface.friction2 = 100.0, 50.0
    link.collisions.append(Shape(Geometry("plane"), name="collision", link="link"))
    link.visuals.append(
        Shape(
            Geometry("box", (100.0, 100.0, 0.002), flat=True),
            Pose((0.0, 0.0, -0.003)),
            GROUND_COLOR,
            name="visual",
            link="link",
            finish=GROUND,
        )
    )
    model.links["link"] = link
    return model


def empty_world() -> WorldDescription:
    """The WorldDescription of Gazebo's empty world: the floor and the sun."""
    return WorldDescription(models=[(ground_plane(), Pose())])
