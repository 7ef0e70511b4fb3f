"""The models of the world as ROS sees them: connected, updated, published, disconnected."""

from __future__ import annotations

import collections
import logging
import threading
import time as wall
import traceback
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.errors import ControllerError
from bullet_sim.parts.base import noise_seed
from bullet_sim.plugins.custom import CustomSpec
from bullet_sim.robots import Loop

from bullet_bridge import plugins  # noqa: F401  enters all plugins
from bullet_bridge.control.robot import RobotControl
from bullet_bridge.loop.received import ReceivedCounts
from bullet_bridge.plugins.base import ModelPlugin, PluginContext, make_plugin
from bullet_bridge.plugins.frames import with_prefixes
from bullet_bridge.resolve import log_warnings

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.plugins.cameras import Cameras

CHECK_PERIOD = 0.02  # [s] of simulated time between two checks for subscribers ...
CHECK_GAP = 0.005  # [s] ... and minimum wall time between them


class Robots(Loop):
    """Controllers, plugins and sensors of all models.

    Args:
        seed: base of all noise seeds.
        extensions: Extensions, which have users' plugin classes.

    Attributes:
        waits_for_renderer: publish() waits while the renderer is being started.

    The loop calls next_due and publish in every batch, so what they use is stored as flat lists and
    one index; `refresh` updates them after jobs.
    """

    def __init__(
        self,
        jobs: JobQueue,
        world: World,
        cameras: Cameras,
        seed: int,
        received: ReceivedCounts | None = None,
        extensions: Any = None,
    ) -> None:
        super().__init__(world)
        self._jobs, self._cameras, self._seed = jobs, cameras, seed
        self.waits_for_renderer = False
        self.received, self.extensions = received or ReceivedCounts(), extensions
        self._claims: dict[str, Model] = {}  # by control namespace
        self._claiming = threading.Lock()
        self._controls: dict[str, RobotControl] = {}
        self._plugins: dict[str, list[ModelPlugin]] = {}
        self._counts: dict[ModelPlugin, int] = {}
        self._failed: set[ModelPlugin] = set()  # plugins that raised an exception
        # Messages about plugins that a model does without, by its name.
        self._skipped: dict[str, list[str]] = {}
        self._next, self._next_watched, self._next_check = 0, 0, 0.0
        self._watched_period: float = 1.0
        self._going_on: list[ModelPlugin] = []  # updated after each batch
        # Parts that watch and do not share a topic, whose messages could change places.
        self._batching: list[ModelPlugin] = []

    def on_time_step(self) -> None:
        """Continue after a change of the physics step (simulation thread)."""
        for plugin in self.parts:
            plugin.on_time_step()
        for control in self.controls:
            control.on_time_step()
        self.refresh()

    # connecting, outside the simulation thread ------------------------------------------------
    def connect(self, model: Model, namespace: str = "") -> None:
        """Create a model's services and topics; called outside the simulation thread."""
        log_warnings(model.description.warnings, model.name)
        self._connect(model, namespace, self._jobs.call)

    def connect_world_models(self) -> None:
        """Connect the models of the world file; called before the simulation runs."""
        for model in list(self._world.models.values()):
            if model.description.sensors or model.manager is not None:
                self._connect(model, "", lambda job: job())

    def _connect(
        self, model: Model, namespace: str, run: Callable[[Callable[[], bool]], bool]
    ) -> None:
        if model.description.log_level:
            logging.getLogger("rosout").setLevel(model.description.log_level)
        parts: list[ModelPlugin] = []
        controls: list[RobotControl] = []

        def begin(set_hardware: Callable[[], None]) -> bool:
            if self._world.models.get(model.name) is model:
                set_hardware()
                for plugin in parts:  # in the same step: gains alone may not be stable
                    plugin.prepare()
            return True

        def register() -> bool:
            if self._world.models.get(model.name) is not model:
                return False
            for plugin in parts:  # steps were made since they were created, perhaps of another size
                plugin.on_time_step()
                plugin.prepare()
            self._plugins[model.name] = parts
            for control in controls:
                control.on_time_step()
                self._controls[model.name] = control
            self._cameras.set_sources(self._world.sources())
            self.refresh()
            return True

        registered = False
        try:
            for index, spec in enumerate(model.description.sensors):
                self._add_plugin(model, index, spec, parts)
            control = self._make_control(
                model, namespace, lambda set_hardware: run(lambda: begin(set_hardware))
            )
            controls += [control] if control is not None else []
            registered = run(register)  # False: the model was deleted in the meantime
        finally:
            if not registered:
                self._close(model, [*controls, *parts])

    def _add_plugin(self, model: Model, index: int, spec: Any, parts: list[ModelPlugin]) -> None:
        """Append one of a model's plugins to a list; one that fails is skipped."""
        seed, spec = noise_seed(self._seed, model.name, index), with_prefixes(spec)
        context = PluginContext(
            self._world,
            model,
            spec,
            seed,
            index,
            self._cameras,
            received=self.received,
            jobs=self._jobs,
        )
        custom = isinstance(spec, CustomSpec)
        try:
            parts.append(make_plugin(context, self.extensions.plugin(spec) if custom else None))
        except (ValueError, ArithmeticError) as error:
            text = f"sensor on {spec.topic} is left out: {error}"
            self._skipped.setdefault(model.name, []).append(text)
            rospy.logerr("model '%s': %s", model.name, text)
        except Exception as error:
            if not custom:
                raise
            text = f"{self.extensions.of(spec)}, and is left out: {error}"
            self._skipped.setdefault(model.name, []).append(text)
            rospy.logerr("model '%s': %s\n%s", model.name, text, traceback.format_exc().rstrip())

    def _make_control(
        self, model: Model, namespace: str, run: Callable[[Callable[[], None]], Any]
    ) -> RobotControl | None:
        """The model's RobotControl; None without a control plugin or if its namespace is taken."""
        if model.manager is None:
            return None
        namespace = (model.description.control_namespace or namespace or model.name).strip("/")
        with self._claiming:
            rival = self._claims.setdefault(namespace, model)
        if rival is not model:
            rospy.logerr(
                "model '%s' has no controllers: '%s' has its controller_manager in the "
                "namespace '/%s' already; give each a robot_namespace",
                model.name,
                rival.name,
                namespace,
            )
            return None
        try:
            return RobotControl(self._jobs, self._world, model, namespace, self.received, run)
        except (rospy.ServiceException, ControllerError) as error:
            self._release(model)
            self._skipped.setdefault(model.name, []).append(f"it has no controllers: {error}")
            rospy.logerr("model '%s' has no controllers: %s", model.name, error)
            return None
        except BaseException:
            self._release(model)
            raise

    def _release(self, model: Model) -> None:
        """Release a model's control namespace for other models; of any thread."""
        with self._claiming:
            self._claims = {
                namespace: owner for namespace, owner in self._claims.items() if owner is not model
            }

    def _close(self, model: Model, parts: Sequence[ModelPlugin | RobotControl]) -> None:
        """Close parts of a failed spawn; if one raises, the others are closed all the same."""
        for part in parts:
            try:
                part.close()
            except Exception as error:
                rospy.logerr("a part of a failed spawn cannot be closed: %s", error)
        self._release(model)

    # simulation thread ------------------------------------------------------------------------
    def disconnect(self, name: str) -> list[Any]:
        """Remove a model.

        Returns:
            Its controls and plugins, which the caller closes.
        """
        control = self._controls.pop(name, None)
        if control is not None:
            control.closed = True
            self._release(control.model)
        removed = self._plugins.pop(name, [])
        self._skipped.pop(name, None)
        for plugin in removed:
            self._counts.pop(plugin, None)
            self._failed.discard(plugin)
        self._cameras.set_sources(self._world.sources())
        self.refresh()
        return [control, *removed] if control is not None else removed

    def refresh(self) -> None:
        """Update the flat lists and the next due step, after jobs."""
        self.controls = tuple(self._controls.values())
        for control in self.controls:
            control.refresh()
        self.parts = tuple(
            plugin
            for of_model in self._plugins.values()
            for plugin in of_model
            if plugin not in self._failed
        )
        topics = collections.Counter(
            topic for part in self.parts if part.watches for topic in part.topics_sent()
        )
        self._batching = [
            part
            for part in self.parts
            if part.watches and all(topics[topic] == 1 for topic in part.topics_sent())
        ]
        self._going_on = [part for part in self.parts if part.goes_on]
        self._update_next(check=True)

    def _update_next(self, check: bool = False) -> None:
        step, now = self._world.step_count, wall.monotonic()
        check = check or now >= self._next_check
        if check:
            self._next_check = now + CHECK_GAP
        latest = step + max(1, round(CHECK_PERIOD / self._world.time_step))
        due, self._next_watched, self._watched_period = self.next_steps(check)
        self._next = min(latest, due)

    def next_due(self) -> int:
        """Physics step after which publish() has to be called at the latest, but for what
        watches."""
        step = self._world.step_count
        going_on = (part.schedule.next_due_subscribed(step, False) for part in self._going_on)
        return min([self._next, *going_on])

    def next_watched(self) -> tuple[int, float]:
        """Physics step after which what watches has to be published, or infinity; the shortest
        period of it [steps]."""
        return self._next_watched, self._watched_period

    def publish_recorded(self, end: int) -> None:
        """See loop.server.Reporter."""
        for part in self._batching:
            if part.schedule.next >= end or not part.schedule.subscribed:
                continue
            recorded = part.recorded()
            if recorded is None:
                continue
            steps = part.schedule.due_before(end)
            sent = self.run(part, part.update_recorded, recorded, steps) or 0
            self._counts[part] = self._counts.get(part, 0) + sent
            part.updated = steps[-1] * self._world.time_step
        self._next_watched = self.next_steps(check=False)[1]

    def publish_watched(self, step: int, time: float) -> None:
        """Update and publish what watches and is due at a step that the world shows."""
        if step >= self._next_watched:
            self.publish_due(step, time)
            self._next_watched = self.next_steps(check=False)[1]

    def publish(self, step: int, time: float) -> None:
        """Update and publish what is due at this step and has subscribers."""
        if step < min(self._next, self._next_watched) and not self._going_on:
            return
        self.publish_due(step, time)
        self._cameras.flush(self._world, self.waits_for_renderer)
        self._update_next()

    def updates(self, part: Any, step: int) -> None:
        """Count the messages."""
        if part.is_message(step):
            self._counts[part] = self._counts.get(part, 0) + 1

    def cannot_publish(self, item: Any, error: Exception) -> None:
        """Log that a state that is NaN or infinite cannot be published."""
        controls = isinstance(item, RobotControl)
        label = f"controllers in '{item.namespace}'" if controls else _label(item)
        rospy.logerr_throttle(5.0, f"{label}: cannot be published: {error}")

    def fail(self, part: Any, error: Exception) -> None:
        """Switch a plugin off that has raised an exception; the simulation continues."""
        rospy.logerr(
            "%s: is switched off, since it has raised an exception:\n%s",
            _label(part),
            traceback.format_exc().rstrip(),
        )
        self._failed.add(part)
        self.parts = tuple(other for other in self.parts if other is not part)
        self._going_on = [other for other in self._going_on if other is not part]

    def skipped(self, model: Model) -> list[str]:
        """Messages about what a model does without: plugins that failed, controllers."""
        control = self._controls.get(model.name)
        refused = [] if control is None else list(control.refused.values())
        return self._skipped.get(model.name, []) + refused

    def parts_of(self, name: str) -> tuple[list[ModelPlugin], RobotControl | None]:
        """Plugins (a list) and RobotControl, or None, of a model."""
        return list(self._plugins.get(name, ())), self._controls.get(name)

    def sensor_counts(self) -> dict[str, int]:
        """Messages so far of each sensor with subscribers, by WORLD::MODEL::LINK::SENSOR."""
        return {self._full_name(plugin): count for plugin, count in self._counts.items()}

    def camera_names(self) -> set[str]:
        """Names of the cameras among those of sensor_counts()."""
        return {self._full_name(plugin) for plugin in self._counts if plugin.takes_images}

    def _full_name(self, plugin: ModelPlugin) -> str:
        name = getattr(plugin.spec, "name", plugin.spec.topic)
        return f"{self._world.name}::{plugin.model.name}::{plugin.spec.link}::{name}"

    def take_failures(self) -> list[str]:
        """Messages about due outputs that could not be made since the last call."""
        return self._cameras.take_failures()

    def show_scene(self) -> None:
        """Show the world's present lights in the images."""
        self._cameras.set_sources(self._world.sources())

    def save_state(self) -> tuple[list[Any], list[Any]]:
        """State of plugins, and the commands that wait for the next step."""
        states = [(plugin, plugin.get_state()) for plugin in self.parts]
        commands = [(control, dict(control.commands)) for control in self._controls.values()]
        return states, commands

    def restore_state(self, state: tuple[list[Any], list[Any]]) -> None:
        """Restore the result of save_state() of the same models, after a restart()."""
        states, commands = state
        for plugin, saved in states:
            plugin.set_state(saved)
        for control, waiting in commands:
            control.commands.update(waiting)
        self.refresh()

    def restart(self, fresh: bool = True) -> None:
        """Restart controls, plugins and cameras after a reset.

        Args:
            fresh: as after a new start; False: commands stay, and what plugins do whose original
                has no Reset(), also what waits for its time of before.
        """
        for control in self._controls.values():
            control.restart(fresh)
        failed = set(self._failed)
        self._failed.clear()
        for of_model in self._plugins.values():
            for plugin in of_model:
                if fresh or plugin.resets_with_model or plugin in failed:
                    plugin.reset(self._world.time)
                    plugin.prepare()
                else:
                    plugin.go_back(self._world.time)
        if fresh:
            self.received.clear()  # the commands are dropped
        self._cameras.restart()
        self._cameras.set_sources(self._world.sources())
        self.refresh()

    def reset_models(self) -> None:
        """Reset the plugins that have something to reset with their model (simulation thread)."""
        for plugin in self.parts:
            if plugin.resets_with_model:
                plugin.reset(self._world.time)
        self.refresh()


def _label(plugin: ModelPlugin) -> str:
    """Name of a plugin in messages."""
    role = "plugin" if plugin.always else "sensor"
    return f"model '{plugin.model.name}', {role} on {plugin.spec.topic}"
