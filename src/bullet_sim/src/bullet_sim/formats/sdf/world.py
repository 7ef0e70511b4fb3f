"""<world> of SDF: physics, models, scene, lights -> WorldDescription."""

from __future__ import annotations

import dataclasses
import functools
import math
import re
from collections.abc import Iterator

from bullet_sim.description.model import Light, ModelDescription
from bullet_sim.description.warnings import Warnings
from bullet_sim.description.world import (
    Fog,
    LinkMotion,
    Place,
    Scene,
    Wind,
    WorldDescription,
    ground_plane,
)
from bullet_sim.errors import BROKEN, ModelError, SimError, reads
from bullet_sim.files import read_file
from bullet_sim.formats.joints import Version
from bullet_sim.formats.lights import child_color, parse_light, sun
from bullet_sim.formats.materials import Resolve
from bullet_sim.formats.sdf.actor import parse_actor
from bullet_sim.formats.sdf.frames import Frames
from bullet_sim.formats.sdf.includes import OpenInclude
from bullet_sim.formats.sdf.model import parse_model_element
from bullet_sim.formats.sdf.old import upgrade
from bullet_sim.formats.sdf.physics import choose_physics, read_physics
from bullet_sim.formats.sdf.population import places
from bullet_sim.formats.sdf.unread import warn_unread
from bullet_sim.formats.shapes import parse_road
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.cpp import cpp_spec
from bullet_sim.plugins.xml import PluginValues, library
from bullet_sim.pose import Pose, Vec3
from bullet_sim.xml_reader import (
    Node,
    add_child,
    child_flag,
    child_floats,
    child_number,
    child_text,
    copied,
    is_true,
    leading_numbers,
    parse,
    sdf_pose,
)

FOGS = {"linear": "linear", "exponential": "exp", "quadratic": "exp2", "exp": "exp", "exp2": "exp2"}


def parse_scene(world: Node, label: str) -> Scene:
    """Scene of a <world>, without lights."""
    scene = world.find("scene")
    if scene is None:
        return Scene(lights=())
    label = f"{label} <scene>"
    has_sky = scene.find("sky") is not None
    background = None if has_sky else child_color(scene, "background", label, Scene.background)
    hour, sunrise, sunset = (
        min(max(child_number(scene, f"sky/{tag}", label, default), 0.0), 24.0)
        for tag, default in zip(("time", "sunrise", "sunset"), Scene.daytime)
    )
    return Scene(
        child_color(scene, "ambient", label, Scene.ambient),
        background,
        child_flag(scene, "shadows", label, True),
        _fog(scene.find("fog"), label),
        (),
        (hour, sunrise, sunset),
    )


def _fog(element: Node | None, label: str) -> Fog | None:
    if element is None:
        return None
    fog_type = FOGS.get((child_text(element, "type") or "none").lower())
    if fog_type is None:
        return None
    label = f"{label} <fog>"
    return Fog(
        fog_type,
        child_color(element, "color", label, Fog.color),
        child_number(element, "start", label, Fog.start),
        child_number(element, "end", label, Fog.end),
        child_number(element, "density", label, Fog.density),
    )


MAX_TIME = 1e9  # [s] at which a world may begin
# World plugins that provide gazebo_ros' services and topics, which exist here without them.
BUILT_IN_PLUGINS = ("gazebo_ros_api_plugin", "gazebo_ros_paths_plugin", "gazebo_ros_init")
# Others that are known; whoever loads the world makes them.
WORLD_PLUGINS = ("gazebo_ros_link_attacher",)
# Tags of a world for Gazebo's windows and solvers, or read elsewhere; ignored without a warning.
_IGNORED = {
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
    "actor",
    "population",
}


def _place(element: Node | None) -> Place:
    """Of <spherical_coordinates>, whose heading is counter-clockwise from the east [degrees]."""
    if element is None:
        return Place()
    latitude, longitude, altitude, heading = (
        child_number(element, tag, "spherical_coordinates", 0.0)
        for tag in ("latitude_deg", "longitude_deg", "elevation", "heading_deg")
    )
    return Place(latitude, longitude, altitude, math.pi / 2.0 - math.radians(heading))


@reads
def parse_world(
    text: str | bytes | Node, resolve: Resolve, label: str = "world"
) -> WorldDescription:
    """Read a world.

    Args:
        text: SDF document with a <world>.
        label: name for messages, e.g. the file's path.

    Raises:
        ModelError: malformed, or no world.
    """
    described = WorldDescription()
    sdf = parse(text, label, described.warnings)
    world = sdf.find("world") if sdf.tag in ("sdf", "gazebo") else None  # gazebo: up to 1.2
    if world is None:
        raise ModelError(f"{label} has no <world> in an <sdf>")
    upgrade(sdf, _version(sdf))
    described.name = world.get("name") or "default"
    warn_unread(sdf)
    described.place = _place(world.find("spherical_coordinates"))
    described.time = max(0.0, _seconds(world.find("state/sim_time")))
    choose_physics(world)
    read_physics(world, described, f"world '{described.name}'")
    described.scene = parse_scene(world, label)
    WorldReader(world, described, resolve, label, _version(sdf)).read()
    return described


class WorldReader:
    """Adds the models, lights, roads and plugins of a <world> to its description."""

    def __init__(
        self,
        world: Node,
        described: WorldDescription,
        resolve: Resolve,
        label: str,
        version: Version,
    ) -> None:
        self._world, self._described, self._resolve = world, described, resolve
        self._label, self._version = label, version
        self._states = {model.get("name"): model for model in world.findall("state/model")}
        self._lights = {light.get("name"): light for light in world.findall("state/light")}
        self._open = functools.lru_cache(maxsize=None)(_opener(resolve, described.warnings))
        self._frames = Frames(world, described.name, self._included)
        nothing = (0.0, 0.0, 0.0)  # [m/s]
        self._wind = child_floats(world, "wind/linear_velocity", 3, f"{label} <wind>", nothing)

    def read(self) -> None:
        """Read all of it."""
        readers = {
            "include": self._add_include,
            "model": self._add_model,
            "light": self._add_light,
            "road": self._add_road,
            "plugin": self._add_plugin,
        }
        for element in self._world:
            if element.tag in readers:
                try:
                    readers[element.tag](element)
                except SimError:
                    raise
                except BROKEN as error:
                    element.warn(
                        f"<{element.tag}> '{element.get('name')}' cannot be read "
                        f"({type(error).__name__}: {error}); it is left out",
                        "elements of the world cannot be read and are left out",
                        f"'{element.get('name')}'",
                    )
            elif element.tag not in _IGNORED:
                name = f" '{element.get('name')}'" if element.get("name") else ""
                self._described.warn(
                    f"{self._label}: <{element.tag}>{name} means nothing here and is ignored",
                    f"<{element.tag}> of the world mean nothing here and are ignored",
                    f"<{element.tag}>{name}",
                )
        # after all other models
        actors = self._world.findall("actor")
        self._described.models += [
            parse_actor(actor, self._label, self._resolve, self._version) for actor in actors
        ]
        for population in self._world.findall("population"):
            self._add_population(population)
        self._insert_and_delete()
        self._number_names()

    def _insert_and_delete(self) -> None:
        """What a <state> inserts, unless its name is taken, and then what it deletes."""
        described = self._described
        taken = {
            "model": {model.name for model, _ in described.models},
            "light": {light.name for light in described.scene.lights},
        }
        add = {"model": self._add_model, "light": self._add_light}
        for insertions in self._world.findall("state/insertions"):
            for element in insertions:
                if element.tag in add and element.get("name") not in taken[element.tag]:
                    add[element.tag](element)
        deleted = {
            (node.text or "").strip() for node in self._world.findall("state/deletions/name")
        }
        described.models = [each for each in described.models if each[0].name not in deleted]
        kept = tuple(each for each in described.scene.lights if each.name not in deleted)
        described.scene = dataclasses.replace(described.scene, lights=kept)

    def _add_light(self, element: Node) -> None:
        state = self._lights.get(element.get("name"))
        pose = None if state is None else sdf_pose(state, f"{self._label} state of a light")
        self._shine(parse_light(element, self._label, pose))

    def _shine(self, light: Light) -> None:
        scene = self._described.scene
        self._described.scene = dataclasses.replace(scene, lights=(*scene.lights, light))

    def _add_road(self, element: Node) -> None:
        model = ModelDescription("road", warnings=self._described.warnings)
        try:
            road = parse_road(element, self._label, model, self._resolve)
        except ModelError as error:
            self._described.warn(f"{error}; it is left out", "roads are left out", self._label)
            return
        if road is not None:
            scene = self._described.scene
            self._described.scene = dataclasses.replace(scene, roads=(*scene.roads, road))

    def _add_model(self, element: Node) -> None:
        state = self._states.get(element.get("name"))
        try:
            if state is not None:
                _move_links(element, state, self._label)
                _scale(element, state, self._label)
            model = _read_model(element, self._resolve, self._version)
            pose = self._frames.pose_of(element, "", f"{self._label} model '{model.name}'")
        except ModelError as error:
            element.warn(
                f"model '{element.get('name')}' is left out: {error}",
                "models are left out",
                f"'{element.get('name')}'",
            )
            return
        if state is not None:
            label = f"{self._label} state of '{model.name}'"
            self._described.starts[model.name] = sdf_pose(state, label)
            self._described.motions[model.name] = dict(_motions(state, "", self._label))
        self._described.models.append((model, pose))

    def _included(self, include: Node) -> Node:
        """The <model> of the file of an <include>; a plain one of ground_plane, which has none."""
        if _database_name(include) == "ground_plane":
            plane = Node("model", name="ground_plane")
            plane.document, plane.line = include.document, include.line
            return plane
        return self._open(include)[0]

    def _add_include(self, element: Node) -> None:
        label = f"{self._label} <include>"
        if _database_name(element) == "sun":
            self._shine(sun(element, label))
            return
        try:
            model = self._included_model(element, label)
        except (OSError, ValueError) as error:
            uri = child_text(element, "uri", "")
            self._described.warn(
                f"{self._label} includes '{uri}', which cannot be used: {error}",
                "included models cannot be used",
                f"'{uri}'",
            )
            return
        if model is not None:
            model.name = child_text(element, "name", model.name)
            model.static = is_true(child_text(element, "static", str(model.static)))
            self._described.models.append((model, self._frames.pose_of(element, "", label)))

    def _included_model(self, element: Node, label: str) -> ModelDescription | None:
        """The model of an <include>; None: it is a light, which is added."""
        if _database_name(element) == "ground_plane":
            return ground_plane()
        inner, version = self._open(element)
        if inner.tag == "light":
            has_pose = element.find("pose") is not None
            pose = sdf_pose(element, label) if has_pose else None
            self._shine(parse_light(inner, self._label, pose))
            return None
        plugins = element.findall("plugin")
        into = add_child(inner, "gazebo", "") if plugins and inner.tag == "robot" else inner
        into.extend(plugins)
        if name := child_text(element, "name"):  # which its plugins have as namespace
            inner.set("name", name)
        return _read_model(inner, self._resolve, version)

    def _add_plugin(self, element: Node) -> None:
        if library(element) == "WindPlugin":
            self._read_wind(element)
        elif library(element) in WORLD_PLUGINS:
            self._described.plugins.append(library(element))
        elif library(element) not in BUILT_IN_PLUGINS:
            self._add_cpp_plugin(element)

    def _add_cpp_plugin(self, element: Node) -> None:
        name = element.get("filename")
        try:
            spec = cpp_spec(element)
        except ModelError as error:
            self._described.warn(
                f"{self._label}: {error}", "world plugins in C++ are left out", f"'{name}'"
            )
            return
        if spec is not None:
            self._described.cpp_plugins.append(spec)
            return
        self._described.warn(
            f"{self._label}: world plugin '{name}' is not known here and is ignored",
            "world plugins are not known here and are ignored",
            f"'{name}'",
        )

    def _read_wind(self, plugin: Node) -> None:
        """Read a WindPlugin; in Gazebo 11.1 it does nothing without a factor."""
        values = PluginValues(plugin, f"plugin '{plugin.get('filename')}'")

        def period(path: str) -> float:
            value = values.number(path, 1.0)
            return value if value > 0.0 else math.inf

        factor = values.number("force_approximation_scaling_factor")
        if abs(factor) < 1e-6:
            self._described.warn(
                f"{values.label} has no <force_approximation_scaling_factor> above 0: there is no "
                "wind, as in Gazebo 11"
            )
            return
        magnitude, direction, vertical = "horizontal/magnitude", "horizontal/direction", "vertical"
        self._described.wind = Wind(
            self._wind,
            factor,
            period(f"{magnitude}/time_for_rise"),
            values.number(f"{magnitude}/sin/amplitude_percent"),
            period(f"{magnitude}/sin/period"),
            period(f"{direction}/time_for_rise"),
            values.number(f"{direction}/sin/amplitude"),
            period(f"{direction}/sin/period"),
            period(f"{vertical}/time_for_rise"),
            tuple(values.noise(f"{path}/noise") for path in (magnitude, direction, vertical)),
        )

    def _add_population(self, population: Node) -> None:
        """Add the models of a <population>, NAME_clone_0 and so on; a faulty one is left out."""
        label = f"{self._label} population '{population.get('name')}'"
        model, include, version = (
            population.find("model"),
            population.find("include"),
            self._version,
        )
        try:
            if model is None and include is not None:
                model, version = _opener(self._resolve, self._described.warnings)(include)
                model.set("name", child_text(include, "name") or model.get("name") or "model")
            if model is None:
                raise ModelError(f"{label} has no <model>")
            for number, place in enumerate(places(population, label)):
                clone = copied(model)
                clone.set("name", f"{model.get('name') or 'model'}_clone_{number}")
                read = _read_model(clone, self._resolve, version)
                self._described.models.append((read, Pose(place)))
        except (OSError, ValueError) as error:
            population.warn(
                f"{error}; it is left out",
                "populations cannot be used and are left out",
                f"'{population.get('name')}'",
            )

    def _number_names(self) -> None:
        """Rename models whose name is taken; Gazebo would refuse them."""
        taken = set()
        for model, _ in self._described.models:
            name, number = model.name, 0
            while model.name in taken:
                number += 1
                model.name = f"{name}_{number}"
            if number:
                self._described.warn(
                    f"{self._label} has more than one model '{name}'; this one becomes "
                    f"'{model.name}'",
                    "models have a name that is taken and get a number",
                    f"'{model.name}'",
                )
            taken.add(model.name)


def _database_name(include: Node) -> str:
    """The name of a model of Gazebo's database that an <include> names."""
    return child_text(include, "uri", "").replace("model://", "").strip("/")


def _move_links(element: Node, state: Node, label: str) -> None:
    """Give the links and models in a <model> without joints the poses, in the world, of its
    <state>; a model has one in any case, as in Gazebo."""
    if element.find("joint") is not None:
        return
    label = f"{label} state of '{element.get('name')}'"
    origin = sdf_pose(state, label).inverse()
    for tag in ("link", "model"):
        parts = {part.get("name"): part for part in element.findall(tag)}
        for moved in state.findall(tag):
            part = parts.get(moved.get("name"))
            if part is None or (tag == "link" and moved.find("pose") is None):
                continue
            local = origin * sdf_pose(moved, f"{label} {tag} '{moved.get('name')}'")
            own = part.find("pose")
            if own is not None:
                part.remove(own)
            values = (*local.position, *local.rpy)
            add_child(part, "pose", " ".join(f"{value:.9g}" for value in values))
            if tag == "model":
                _move_links(part, moved, label)


def _scale(element: Node, state: Node, label: str) -> None:
    """Multiply the sizes of a <model>'s shapes by the <scale> of its <state>, as Gazebo's
    Model::SetScale: poses, masses and the models inside keep theirs."""
    x, y, z = factors = child_floats(state, "scale", 3, label, (1.0, 1.0, 1.0))
    if factors == (1.0, 1.0, 1.0):
        return
    for shape, tag, by in (
        ("box", "size", factors),
        ("sphere", "radius", (max(factors),)),
        ("cylinder", "radius", (max(x, y),)),
        ("cylinder", "length", (z,)),
        ("mesh", "scale", factors),
    ):
        paths = (f"link/{kind}/geometry/{shape}" for kind in ("collision", "visual"))
        for node in (node for path in paths for node in element.findall(path)):
            text = child_text(node, tag, "1 1 1" if shape == "mesh" else "")
            values, rest = leading_numbers(text, len(by))
            if not rest and len(values) == len(by):  # else whoever reads it says so
                for old in node.findall(tag):
                    node.remove(old)
                scaled = (f"{value * factor:.9g}" for value, factor in zip(values, by))
                add_child(node, tag, " ".join(scaled))


def _motions(state: Node, prefix: str, label: str) -> Iterator[tuple[str, LinkMotion]]:
    """How links start by the <state> of a <model>: (name in the outermost model, LinkMotion)."""
    for link in state.findall("link"):
        name = f"{prefix}{link.get('name')}"
        numbers: list[float] = []
        for tag in ("velocity", "wrench"):
            numbers += child_floats(link, tag, 6, f"{label} link '{name}'", (0.0,) * 6)
        if any(numbers):
            vectors: list[Vec3] = [(x, y, z) for x, y, z in zip(*[iter(numbers)] * 3)]
            yield name, LinkMotion(*vectors)
    for model in state.findall("model"):
        yield from _motions(model, f"{prefix}{model.get('name')}::", label)


def _version(sdf: Node) -> Version:
    """(major, minor) of an <sdf>; (1, 6) where it gives no valid one."""
    match = re.match(r"\s*(\d+)\.(\d+)", sdf.get("version") or "")
    return (int(match.group(1)), int(match.group(2))) if match else (1, 6)


def _seconds(element: Node | None) -> float:
    """A time [s] as saved worlds have it: seconds and nanoseconds; 0 where it is none."""
    values, rest = leading_numbers(element.text if element is not None else None, 2)
    seconds, nanoseconds = (*values, 0.0, 0.0)[:2]
    time = seconds + 1e-9 * nanoseconds
    return time if not rest and math.isfinite(time) and time < MAX_TIME else 0.0


def _opener(resolve: Resolve, warnings: Warnings) -> OpenInclude:
    """Function <include> -> (<model> element, SDF version of its file)."""

    def open_include(include: Node) -> tuple[Node, Version]:
        path = resolve(child_text(include, "uri", ""))
        sdf = parse(read_file(path, "SDF", "text_bytes"), path, warnings)
        if sdf.tag != "robot":
            upgrade(sdf, _version(sdf))
            warn_unread(sdf)
        return _model_of(sdf, path), _version(sdf)

    return open_include


def _read_model(element: Node, resolve: Resolve, version: Version) -> ModelDescription:
    """Read a <model>, or the <robot> of a URDF that an <include> leads to."""
    if element.tag == "robot":
        warnings = element.document.warnings
        model = parse_urdf(element, resolve, element.get("name") or "robot")
        for warning in model.warnings:
            warnings.add(warning, warning.cause, warning.item)
        return model
    opener = _opener(resolve, element.document.warnings)
    return parse_model_element(element, resolve, version, opener)


def _model_of(sdf: Node, label: str) -> Node:
    """The <model> of a document, or the <light> of one that has no model; the <robot> of a URDF."""
    element = sdf if sdf.tag in ("model", "robot") else sdf.find("model")
    element = sdf.find("light") if element is None else element
    if element is None:
        raise ModelError(f"{label} has no <model>")
    return element


@reads
def parse_model(
    text: str | bytes | Node, resolve: Resolve, label: str = "model", name: str = ""
) -> tuple[ModelDescription, Pose]:
    """Read the first <model> of an SDF document, or of its <world>: (ModelDescription, its pose).

    Args:
        name: of the first <model>, or the first <include> of the <world>, instead of its own.
    """
    sdf = parse(text, label)
    if name:
        _rename(sdf, name)
    world = sdf.find("world") if sdf.tag != "model" and sdf.find("model") is None else None
    if world is None:
        upgrade(sdf, _version(sdf))
        warn_unread(sdf)
        element = _model_of(sdf, label)
        pose = sdf_pose(element, f"{label} model '{element.get('name')}'")
        return _read_model(element, resolve, _version(sdf)), pose
    described = parse_world(sdf, resolve, label)
    if not described.models:
        raise ModelError(
            "; ".join(described.warnings) or f"{label} has a <world> with 0 models, must be one"
        )
    return described.models[0]


def _rename(sdf: Node, name: str) -> None:
    """Give the first <model> of a document, or the first <include> of its <world>, a name.

    As gazebo_ros does it for a request to spawn it.
    """
    model, include = sdf if sdf.tag == "model" else sdf.find("model"), sdf.find("world/include")
    if model is not None:
        model.set("name", name)
    elif include is not None:
        for old in include.findall("name"):
            include.remove(old)
        add_child(include, "name", name)
        if include.find("pose") is None:  # gazebo_ros writes one, which replaces the file's
            add_child(include, "pose", "0 0 0 0 0 0")
