"""SDF worlds -> models; SDF documents with one model, for spawning."""

from dataclasses import dataclass, field

from bullet_sim.description.parts import Geometry, Link, ModelDescription, Shape
from bullet_sim.errors import ModelError
from bullet_sim.formats.sdf.model import parse_model_element
from bullet_sim.formats.xml_read import child_number, child_text, floats, is_true, parse, sdf_pose
from bullet_sim.pose import Pose

# Models built into Gazebo: the ground is an infinite plane, the sun a light.
GROUND_COLOR = (0.6, 0.6, 0.6, 1.0)
NOTHING = ("sun",)
MIN_STEP = 1e-6  # [s] shortest physics step
# Tags of a world that only concern Gazebo's own windows and solvers.
_QUIET = {
    "gravity",
    "physics",
    "scene",
    "gui",
    "audio",
    "wind",
    "atmosphere",
    "magnetic_field",
    "spherical_coordinates",
    "state",
    "frame",
    "light",
}


@dataclass
class WorldDescription:
    """Contents of a world file; models with their world poses, in file order.

    Attributes:
        gravity: [m/s^2].
        step: of the physics [s].
        real_time_factor: simulated seconds per wall second that the file asks for; 0: as fast
            as possible.
    """

    name: str = "default"
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    step: float = 0.001
    real_time_factor: float = 1.0
    models: list[tuple[ModelDescription, Pose]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def parse_world(text, resolve, what="world"):
    """Read a world.

    Args:
        text: SDF document with a <world>.
        resolve: function URI -> path of a file.
        what: name for messages, e.g. the file's path.

    Raises:
        ModelError: malformed or wrong numbers.
    """
    sdf = parse(text, what)
    world = sdf.find("world") if sdf.tag == "sdf" else None
    if world is None:
        raise ModelError(f"{what} has no <world> in an <sdf>")
    described = WorldDescription(world.get("name") or "default")
    _physics(world, described, what)
    states = {model.get("name"): model for model in world.findall("state/model")}
    for element in world:
        if element.tag == "include":
            _include(element, described, resolve, what)
        elif element.tag == "model":
            model, pose = _placed(element, resolve, what, _version(sdf))
            if model.name in states:
                pose = sdf_pose(states[model.name], f"{what} state of '{model.name}'")
            described.models.append((model, pose))
        else:
            _other(element, described, what)
    _number_names(described, what)
    return described


def _number_names(described, what):
    """Rename models whose name is taken; Gazebo would refuse them."""
    taken = set()
    for model, _ in described.models:
        name, number = model.name, 0
        while model.name in taken:
            number += 1
            model.name = f"{name}_{number}"
        if number:
            described.warnings.append(
                f"{what} has more than one model '{name}'; this one becomes '{model.name}'"
            )
        taken.add(model.name)


def _version(sdf):
    try:
        return float(sdf.get("version") or 1.6)
    except ValueError:
        return 1.6


def _physics(world, described, what):
    gravity = child_text(world, "gravity") or child_text(world, "physics/gravity")
    if gravity:
        described.gravity = floats(gravity, 3, f"{what} <gravity>")
    described.step = child_number(world, "physics/max_step_size", what, 0.001)
    if described.step < MIN_STEP:
        raise ModelError(
            f"{what} <max_step_size> is {described.step}, must be at least {MIN_STEP:g} [s]"
        )
    rate = child_number(world, "physics/real_time_update_rate", what, 1.0 / described.step)
    if rate < 0:
        raise ModelError(f"{what} <real_time_update_rate> is {rate}, must be 0 or more")
    described.real_time_factor = rate * described.step


def _other(element, described, what):
    if not isinstance(element.tag, str) or element.tag in _QUIET:
        return
    if element.tag == "plugin":
        text = f"{what}: world plugin '{element.get('filename')}' is not known here and is ignored"
    else:
        name = f" '{element.get('name')}'" if element.get("name") else ""
        text = f"{what}: <{element.tag}>{name} means nothing here and is ignored"
    if text not in described.warnings:
        described.warnings.append(text)


def _include(element, described, resolve, what):
    uri = child_text(element, "uri", "")
    plain = uri.replace("model://", "").strip("/")
    pose = sdf_pose(element, f"{what} <include>")
    if plain in NOTHING:
        return
    try:
        if plain == "ground_plane":
            model, own = ground_plane(), pose
        else:
            inner, version = _opener(resolve)(element)
            for plugin in element.findall("plugin"):
                inner.append(plugin)
            model, own = _placed(inner, resolve, what, version)
    except (OSError, ValueError) as error:
        described.warnings.append(f"{what} includes '{uri}', which cannot be used: {error}")
        return
    model.name = child_text(element, "name", model.name)
    model.static = is_true(child_text(element, "static", str(model.static)))
    described.models.append((model, pose if element.find("pose") is not None else own))


def _opener(resolve):
    """Function <include> -> (<model> element, SDF version of its file)."""

    def open_include(include):
        path = resolve(child_text(include, "uri", ""))
        with open(path, "rb") as file:
            sdf = parse(file.read(), path)
        return _model_of(sdf, path), _version(sdf)

    return open_include


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


def _placed(element, resolve, what, version=1.6):
    model = parse_model_element(element, resolve, version, _opener(resolve))
    return model, sdf_pose(element, f"{what} model '{element.get('name')}'")


def _model_of(sdf, what):
    element = sdf if sdf.tag == "model" else sdf.find("model")
    if element is None:
        raise ModelError(f"{what} has no <model>")
    return element


def parse_model(text, resolve, what="model"):
    """Read an SDF document with one <model>: (ModelDescription, its own pose).

    Args:
        text: the document.
        resolve: function URI -> path of a file.
        what: name for messages.
    """
    sdf = parse(text, what)
    if sdf.find("model") is None and sdf.find("world") is not None:
        return _only_model(parse_world(text, resolve, what), what)
    return _placed(_model_of(sdf, what), resolve, what, _version(sdf))


def _only_model(world, what):
    """The one model of a world: spawn_model's -database sends a world that includes it."""
    if len(world.models) != 1:
        raise ModelError(
            "; ".join(world.warnings)
            or f"{what} has a <world> with {len(world.models)} models, must be one"
        )
    return world.models[0]
