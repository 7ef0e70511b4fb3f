"""Gazebo's World in this process: it has the models of ours, and our solver makes its steps."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import rosgraph
import rospy
from bullet_sim.description.model import Joint
from bullet_sim.engine.api import WORLD, Rays
from bullet_sim.engine.efforts import EffortRow
from bullet_sim.engine.quickstep import layout
from bullet_sim.errors import SimError
from bullet_sim.plugins.contacts import ContactReader
from bullet_sim.plugins.cpp import CppSpec
from bullet_sim.pose import Array, Pose, vector3

from bullet_bridge.gazebo_host import texts
from bullet_bridge.gazebo_host.libraries import CAST, STEP, HostLibrary
from bullet_bridge.gazebo_host.models import ModelChange, Models

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

MADE = "of a C++ plugin"  # in keys of joints that plugins have made
OF_RENDERER = ("camera", "depth", "gpu_ray", "multicamera", "wideanglecamera")  # types of sensors
_hosts: list[GazeboHost] = []
_makers: list[Models] = []


def make_models_by(models: Models) -> None:
    """Have models that plugins insert and remove made so; else they are in the world alone."""
    _makers[:] = [models]


def host_of(world: World) -> GazeboHost:
    """The host of a world, which is made when it is first asked for.

    Raises:
        SimError: Gazebo's libraries are not there, the solver is another one, or this process has
            the host of another world.
    """
    if not _hosts:
        _hosts.append(GazeboHost(world, rosgraph.get_master_uri()))
    if _hosts[0].world is not world:
        raise SimError("this process has the C++ plugins of another world already")
    return _hosts[0]


def _numbers(pose: Pose) -> Array:
    return np.array((*pose.position, *pose.orientation), float)


class GazeboHost:
    """Has plugins in C++ act on a world, as Gazebo does (simulation thread).

    Args:
        world: of the solver 'ode'.
        master: URI of ROS's master, of which plugins are clients; '': of none.

    Attributes:
        world: whose steps it makes, from when it has a plugin.
    """

    def __init__(self, world: World, master: str = "") -> None:
        if world.engine.settings is None:
            raise SimError("plugins in C++ need the solver 'ode', this is 'bullet'")
        self.world = world
        self._engine: Any = world.engine  # with rows: of the solver 'ode'
        self._library: Any = HostLibrary()
        library = self._library
        name = rospy.get_name().strip("/").replace("/", "_")
        library.check(library.open(master.encode(), f"{name}_cpp".encode()), "C++ plugins")
        library.check(library.world(texts.world_text(world).encode()), "Gazebo's world")
        self._models_of_plugins = _makers[0] if _makers else Models(world)
        columns = library.columns().decode().split()
        self._chosen = np.array([getattr(layout, name) for name in columns], np.int32)
        self._rest = np.array((layout.REST_TIME, layout.REST_COUNT), float)
        self._models: tuple[Model, ...] = ()  # that Gazebo's world has
        self._static: dict[Model, Pose] = {}  # where it has those without rows
        self._arrays: Any = None  # whose rows it knows
        self._stepped = True  # since the last reset
        self._work: Any = None  # of the step that is made
        self._result: Array | None = None
        self._error: BaseException | None = None
        self._problems: dict[Model, dict[int, str]] = {}  # of sensors, by their elements
        self._watched_models: tuple[Model, ...] = ()  # of whom the readers are
        self._readers: tuple[bytes, list[ContactReader]] = (b"", [])
        self._calls = STEP(self._make_step), CAST(self._cast_rays), STEP(self._tell_contacts)
        library.calls(*self._calls)
        self._buffer = np.zeros(18)  # which the library writes into
        self._made, self._facts = ctypes.c_bool(), (ctypes.c_int * 3)()
        rospy.on_shutdown(library.close)

    def load(self, spec: CppSpec, model: Model | None) -> None:
        """Load a plugin of a model, or of the world, between two steps.

        Raises:
            SimError: it cannot be loaded; says why.
        """
        self._synchronize()
        if model is not None and model not in self._problems:
            self._problems[model] = dict(self._make_sensors(model))
        if spec.sensor is not None and model is not None:
            problem = self._problems[model].get(id(spec.sensor))
            if problem:
                name = spec.sensor.get("name")
                raise SimError(f"sensor '{name}' with plugin '{spec.name}' is not made: {problem}")
        else:
            library, name = self._library, "" if model is None else model.name
            text = texts.with_plugin(spec.text, name)
            loaded = library.load_plugin(name.encode(), text.encode(), spec.folder.encode())
            library.check(loaded, f"plugin '{spec.name}' is not loaded")
        self.world.stepper, self.world.stepper_is_idle = self.step, self._is_idle
        self._stepped = True

    def _make_sensors(self, model: Model) -> Iterator[tuple[int, str]]:
        """Make a model's sensors, which its plugins may look for; gives why each is not made."""
        library, name, description = self._library, model.name, model.description
        holders = [*description.sensor_elements]
        holders += [(name, Pose(), each) for name, each in description.joint_sensor_elements]
        for link, pose, element in holders:
            specs = (spec for spec in description.sensors if isinstance(spec, CppSpec))
            plugins = [spec for spec in specs if spec.sensor is element]
            if not plugins and element.get("type") in OF_RENDERER:
                continue
            library.load_sensors()
            texts_of = [plugin.text for plugin in plugins]
            link, text = texts.sensor_text(model, link, pose, element, texts_of)
            folders = ":".join(plugin.folder for plugin in plugins)
            arguments = name, link, text, folders
            if not library.load_sensor(*(each.encode() for each in arguments)):
                yield id(element), library.error().decode(errors="replace")

    def reset(self, time: float) -> None:
        """Tell all plugins of a reset, once; of time, too, where that is 0 [s]."""
        if self._stepped:
            self._stepped = False
            self._synchronize()
            self._library.check(self._library.reset(time == 0.0), "a reset of C++ plugins")

    def step(
        self, count: int = 1, efforts: Sequence[EffortRow] = (), records: bool = False
    ) -> Array | None:
        """As Engine.step, with Gazebo's events before and after it: before and after all where
        there are several, which only are together where no plugin is called at each step."""
        self._take_models()
        self._synchronize()
        self._stepped = True
        self._work, self._result, self._error = (count, efforts, records), None, None
        library, world = self._library, self.world
        done = library.step(world.time, world.time_step, count, ctypes.byref(self._made))
        if self._error is not None:
            raise self._error
        if not done:
            self._unload()
        if not self._made:
            self._make_step()
        self._work = None
        return self._result

    def _is_idle(self) -> bool:
        """Whether no plugin is called at each step; see paddock_is_idle()."""
        return bool(self._library.is_idle())

    def _take_models(self) -> None:
        """Insert and remove what plugins have asked for."""
        library, buffer, facts = self._library, self._buffer, self._facts
        while (what := library.next_model(facts, buffer.ctypes.data)) is not None:
            kind, has_pose, may_rename = facts
            x, y, z, *turn = buffer[:7].tolist()
            pose = Pose((x, y, z), (*turn,)) if has_pose else None
            change = ModelChange(kind, what.decode(errors="replace"), pose, bool(may_rename))
            try:
                self._models_of_plugins.make(change)
            except SimError as error:
                rospy.logerr("a model of a C++ plugin is not inserted: %s", error)

    def _unload(self) -> None:
        """Go on without the plugin that has thrown something."""
        reason = self._library.error().decode(errors="replace")
        plugin = self._library.unload_faulty().decode(errors="replace")
        what = f"{plugin}: is unloaded, since" if plugin else "a C++ plugin, which is not known:"
        rospy.logerr("%s %s", what, reason)

    def _make_step(self) -> None:
        """The solver's step, within Gazebo's."""
        try:
            self._take_changes()
            self._result = self._engine.step(*self._work)
            self._use_arrays()
        except BaseException as error:  # C++ is below: it is raised again above it
            self._error = error

    def _take_changes(self) -> None:
        """What plugins have set that has no rows."""
        library, buffer = self._library, self._buffer
        while (name := library.next_moved(buffer.ctypes.data)) is not None:
            x, y, z, *turn = buffer[:7].tolist()
            model = self.world.models.get(name.decode())
            if model is not None:
                self._static[model] = pose = Pose((x, y, z), tuple(turn))
                model.set_state(pose)
        if library.gravity(buffer.ctypes.data):
            x, y, z = buffer[:3].tolist()
            self._engine.set_gravity((x, y, z))
        while (text := library.next_joint(buffer.ctypes.data)) is not None:
            number, attach, *what = text.decode().split("\n")
            try:
                self._change_joint((MADE, int(number)), attach == "1", what)
            except SimError as error:
                rospy.logerr("a joint that a C++ plugin has made is not simulated: %s", error)

    def _change_joint(self, key: tuple[str, int], attach: bool, what: Sequence[str]) -> None:
        """Attach or detach a joint that a plugin has made; see paddock_next_joint()."""
        if not attach:
            self._engine.detach(key)
            return
        if self._engine.attach_again(key):
            return
        kind, *links = what
        (parent, _), (child, inner) = (self._in_body(*links[i : i + 2]) for i in (0, 2))
        if child == WORLD:
            raise SimError("its child is the world, must be a link")
        numbers = self._buffer.tolist()
        lower, upper, effort, velocity, damping, friction, stiffness, rest = numbers[10:]
        joint = Joint(
            "made",
            kind,
            "",
            "",
            axis=vector3(numbers[7:10]),
            lower=lower if lower > -texts.UNLIMITED else None,
            upper=upper if upper < texts.UNLIMITED else None,
            effort=max(effort, 0.0),
            velocity=max(velocity, 0.0),
            damping=damping,
            friction=friction,
            stiffness=stiffness,
            rest=rest,
            anchor=inner * Pose(vector3(numbers[:3]), (*numbers[3:7],)),
        )
        self._engine.attach_by_joint(key, parent, child, None if kind == "fixed" else joint)

    def _in_body(self, model: str, link: str) -> tuple[Any, Pose]:
        """The engine's link that has a link of Gazebo's, and the pose of that one in it."""
        if not model:
            return WORLD, Pose()
        found = self.world.model(model)
        part, offset = found.link_in_body(link)
        return (found.body.number, part), offset

    def _cast_rays(
        self, center: Any, along: Any, count: int, near: float, far: float, distances: Any
    ) -> None:
        """Distances (count,) to what rays hit [m]; see engine.hh."""
        try:
            start = np.ctypeslib.as_array(center, (3,)).copy()
            directions = np.ctypeslib.as_array(along, (count, 3)).copy()
            found = self._engine.cast_rays(Rays(start, directions, near, far))
            np.ctypeslib.as_array(distances, (count,))[:] = found
        except (ArithmeticError, ValueError) as error:
            self._error = error

    def _tell_contacts(self) -> None:
        """The last step's contacts of collisions that somebody watches."""
        try:
            names = self._library.watched_collisions()
            if names != self._readers[0] or self._models != self._watched_models:
                self._watched_models = self._models
                self._readers = names, list(self._contact_readers(names.decode()))
            pairs = {}
            for reader in self._readers[1]:
                pairs.update({(pair.first, pair.second): pair for pair in reader.pairs(0.0)})
            for pair in pairs.values():
                back = np.zeros((len(pair.depths), 6)) if pair.back is None else pair.back
                depths = np.reshape(pair.depths, (-1, 1))
                parts = pair.positions, pair.normals, depths, pair.wrenches, back
                numbers = np.hstack(parts)
                first, second = pair.first.encode(), pair.second.encode()
                self._library.add_contacts(first, second, numbers.ctypes.data, len(numbers))
        except BaseException as error:  # C++ is below: it is raised again above it
            self._error = error

    def _contact_readers(self, names: str) -> Iterator[ContactReader]:
        wanted = set(names.split("\n"))
        for model in self._models:
            if model.body.number < 0 or (names == "*" and model.is_static):
                continue
            own: dict[str, set[str]] = {}
            for (link, _), name in model.collision_names.items():
                full = f"{model.name}::{name}"
                if full in wanted or names == "*":
                    own.setdefault(model.link_in_body(link)[0], set()).add(full)
            for link, monitored in own.items():
                yield ContactReader(self.world, model, link, monitored, tells_back=True)

    # What Gazebo's world has --------------------------------------------------------------------
    def _synchronize(self) -> None:
        """Have Gazebo's world know what has changed in ours since the last step."""
        models = tuple(self.world.models.values())
        if models != self._models:
            self._change_models(models)
        self._engine.refresh()
        self._use_arrays()
        for model, pose in self._static.items():
            if model.pose != pose:
                self._static[model] = model.pose
                self._place(model)
        self._library.pull()

    def _change_models(self, models: tuple[Model, ...]) -> None:
        library = self._library
        known, self._models, self._arrays = self._models, models, None
        for model in known:
            if model not in models:
                self._static.pop(model, None)
                self._problems.pop(model, None)
                library.remove(model.name.encode())
        for model in models:
            if model in known or model.body.number < 0:  # an actor
                continue
            if not library.insert(texts.model_text(model).encode()):
                reason = library.error().decode(errors="replace")
                rospy.logerr("model '%s' is not seen by C++ plugins: %s", model.name, reason)
            elif model.description.static or model.description.fixed_base:
                self._static[model] = model.pose

    def _place(self, model: Model) -> None:
        numbers = _numbers(model.pose)
        self._library.place(model.name.encode(), numbers.ctypes.data)

    def _use_arrays(self) -> None:
        """Tell where the rows of links and joints are, after the arrays were built."""
        engine = self._engine
        if engine.arrays is self._arrays:
            return
        self._arrays = engine.arrays
        self._library.tables(
            engine.rows.ctypes.data,
            engine.joint_rows.ctypes.data,
            self._chosen.ctypes.data,
            self._rest.ctypes.data,
            layout.INFINITE,
        )
        for model in self._models:
            if model.body.number >= 0:
                self._bind(model)
        types = self._arrays.state.system.types
        for key, row in self._arrays.attached.items():
            if key[0] == MADE:
                self._library.bind_made(key[1], row, *types[row, 1:].tolist())

    def _bind(self, model: Model) -> None:
        library, name = self._library, model.name.encode()
        rows, types = self._arrays.rows, self._arrays.state.system.types
        for link in model.bodies:
            part, offset = model.link_in_body(link)
            row = rows.get((model.body.number, part), -1)
            frame = offset if row < 0 else Pose(self._arrays.inward[row]) * offset
            numbers = _numbers(frame)
            library.bind_link(name, link.encode(), row, numbers.ctypes.data, part == link)
        for joint in texts.joints_of(model):
            if joint.name in model.body.joints:
                row = self._engine.bodies[model.body.number].motor(joint.name).row
                one, two = types[row, 1:].tolist()
                library.bind_joint(name, joint.name.encode(), row, one, two)
