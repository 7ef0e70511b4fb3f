"""What models do and measure: the base of drives, sensors and other plugins, without ROS."""

from __future__ import annotations

import logging
import sys
import time as wall
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Hashable, TypeVar

import numpy as np

from bullet_sim.component import Component
from bullet_sim.parts.outputs import NumbersOutput, Output, Sender
from bullet_sim.parts.schedule import SubscribedSchedule, whole_rate
from bullet_sim.pose import Array, Pose, Quat, Vec3, compose, cross, velocity_at
from bullet_sim.registry import ByClass

if TYPE_CHECKING:
    from bullet_sim.models.model import Model

T = TypeVar("T")

# Class of a specification -> the Part that does it.
PARTS: ByClass[type[Part]] = ByClass()
part_of = PARTS.enter
_log = logging.getLogger("paddock")


def noise_seed(seed: int, model: str, number: int) -> int:
    """Seed of the noise of the part that is entry `number` of a model's file."""
    return zlib.crc32(f"{seed}/{model}/{number}".encode())


@dataclass(frozen=True)
class PartContext:
    """What a part gets when its model is connected.

    Attributes:
        spec: its entry in the model's file.
        seed: of its noise.
        number: of the entry in the model's file, from 0.
        cameras: have images rendered: add(part), remove(part), request(CameraRequest).
        connect: makes what sends an Output; None: the part has its own output().
    """

    world: Any
    model: Model
    spec: Any
    seed: int = 0
    number: int = 0
    cameras: Any = None
    connect: Callable[[Output], Sender] | None = None


class Part(Component):
    """Acts on its model or measures it, has topics. It runs whether or not there are subscribers.

    Attributes:
        COMMANDS: field of the specification with the name of a topic that it subscribes to ->
            type of its messages (in ROS, or its name), name of the method that gets each one. It
            subscribes after the first reset, which would drop them, and to no topic without a name.
        schedule: of its updates.
        rng: generator of its noise, seeded.
        updated: time of the last update, or of the reset [s].
        every_step: update() is called after every physics step, not at the rate of the spec.
        whole_periods: each period counts from the step of the update before, as Gazebo's sensors
            (SensorManager's threads sleep for a period) and those of its plugins that say so.
        always: it is updated without subscribers, too.
        resets: /gazebo/reset_world resets it, as upstream's Reset() does; as an attribute of the
            specification it counts instead.
        waits_for_time: after simulated time went back it is silent until its time of before has
            passed again, as its original, which does not notice.
        reports: it publishes periodically, so that its rate can be measured.
        takes_images: it is a camera.
        needs_ros: it cannot do without what ROS has beside topics.
        goes_on: what it does goes on within a batch of steps, see BatchSchedule.
        watches: update() reads no more than time, poses, velocities and joints after a step, and
            changes nothing that steps depend on: it may be called after later ones, see World.show.
        tells_velocities: a part that watches reads them.
    """

    STATE: ClassVar[tuple[str, ...]] = ("schedule", "rng", "updated", "_asked")
    CACHE: ClassVar[tuple[str, ...]] = ("_logged", "senders")
    COMMANDS: ClassVar[Mapping[str, tuple[Any, str]]] = {}
    every_step: ClassVar[bool] = False
    goes_on: ClassVar[bool] = False
    whole_periods: bool = False
    always: ClassVar[bool] = True
    reports: ClassVar[bool] = False
    takes_images: ClassVar[bool] = False
    needs_ros: ClassVar[bool] = False
    watches: bool = False
    tells_velocities: ClassVar[bool] = True
    resets: ClassVar[bool] = True
    waits_for_time: ClassVar[bool] = False

    def __init__(self, context: Any) -> None:
        self.context, self.updated = context, 0.0
        self.world, self.model, self.spec = context.world, context.model, context.spec
        self.rng = np.random.default_rng(context.seed)
        self.senders: list[Sender] = []
        self._logged: dict[Hashable, float] = {}  # wall times at which texts were logged [s]
        self._asked: float = getattr(self.spec, "rate", 0.0)  # [Hz], 0: every step
        self.schedule = SubscribedSchedule(
            self._rate(),
            self.world.time_step,
            self.world.step_count,
            self.needs_update,
            lambda: self.start(self.world.time),
        )
        offset = Pose.from_xyz_rpy(*getattr(self.spec, "pose", ((0, 0, 0), (0, 0, 0))))
        self._offset = None if offset == Pose() else offset

    # topics and messages, which the bridge overrides ------------------------------------------
    def output(self, output: Output) -> Any:
        """What sends on a topic, see Sender."""
        sender = self.context.connect(output)
        self.senders.append(sender)
        return sender

    def log(self, level: int, text: str) -> None:
        """Log a text at a level of the module logging."""
        _log.log(level, "%s", text)

    def log_info(self, text: str) -> None:
        """Tell of something usual."""
        self.log(logging.INFO, text)

    def log_warning(self, text: str, every: float = 0.0) -> None:
        """Tell of something that is not as asked for; every: see log_error."""
        self._tell(logging.WARNING, text, every)

    def log_error(self, text: str, every: float = 0.0) -> None:
        """Tell of an error; from one place of the code, [s] of wall time apart at least."""
        self._tell(logging.ERROR, text, every)

    def _tell(self, level: int, text: str, every: float) -> None:
        place = sys._getframe(2)
        key, now = (place.f_code, place.f_lineno), wall.monotonic()
        if key not in self._logged or now - self._logged[key] >= every:
            self._logged[key] = now
            self.log(level, text)

    # what ROS has beside topics, of which there is nothing without it --------------------------
    def offer(self) -> None:
        """Offer services and parameters; called once, in ROS alone."""

    def service(self, name: str, service: Any, handler: Callable[[Any], Any]) -> None:
        """Offer a service of a type (in ROS, or its name).

        Args:
            handler: function of a request -> response, or its fields; what it raises as a SimError
                is the client's error. It runs in a thread of its own, see call().
        """

    def reconfigure(
        self, namespace: str, config: Any, values: Any, callback: Callable[[Any, int], Any]
    ) -> None:
        """Offer parameters by dynamic_reconfigure.

        Args:
            config: (name, type, default, minimum, maximum, description) of each parameter.
            values: name -> first value.
            callback: function of the values and a level -> values; it runs in a thread of its own.
        """

    def transforms(self) -> Any:
        """What finds transforms: pose_in(frame, child) -> Pose, which raises a LookupError."""

    def call(self, work: Callable[[], T]) -> T:
        """Result of a function that the simulation thread runs, for services and callbacks."""
        return work()

    def commands(self) -> dict[str, tuple[Any, Callable[[Any], None]]]:
        """Topics that it takes commands from: the type of the messages, what gets each one."""
        return {
            topic: (message, getattr(self, method))
            for field, (message, method) in self.COMMANDS.items()
            if (topic := getattr(self.spec, field))
        }

    def needs_update(self) -> bool:
        """Whether it is to be updated: always, or while a topic of it has subscribers."""
        return self.always or self.is_subscribed()

    def is_subscribed(self) -> bool:
        """Whether a topic of it has subscribers."""
        return any(sender.has_subscribers() for sender in self.senders)

    # time -------------------------------------------------------------------------------------
    def _rate(self) -> float:
        """Of updates [Hz]; at most one a physics step, as in Gazebo."""
        return 1.0 / self.world.time_step if self.every_step else self._message_rate()

    @property
    def nominal_rate(self) -> float:
        """Of what it publishes [Hz] of simulated time."""
        return self._message_rate()

    def _message_rate(self) -> float:
        fastest = 1.0 / self.world.time_step
        rate = min(self._asked, fastest) if self._asked > 0.0 else fastest
        return whole_rate(rate, self.world.time_step) if self.whole_periods else rate

    def on_time_step(self) -> None:
        """Continue after a change of the physics step, or of the rate (simulation thread)."""
        self.schedule.set_step(self.world.time_step, self._rate(), self.world.step_count)

    def set_rate(self, rate: float) -> None:
        """Change the rate of the updates [Hz]; 0: every physics step (simulation thread)."""
        self._asked = rate
        self.on_time_step()

    def prepare(self) -> None:
        """Prepare the model, once it is there and after each reset (simulation thread)."""

    def reset(self, time: float) -> None:
        """Restart as configured: schedule, noise, start()."""
        self.restart(time)

    def restart(self, time: float) -> None:
        """Restart schedule, noise and measurements after time went back; commands stay."""
        self.schedule.restart(self.world.step_count)
        self.rng, self.updated = np.random.default_rng(self.context.seed), time
        self.start(time)

    def go_back(self, time: float) -> None:
        """As restart(), unless it waits for its time: see waits_for_time."""
        if not self.waits_for_time:
            self.restart(time)

    @property
    def resets_with_model(self) -> bool:
        """Whether a reset of its model alone resets it."""
        return getattr(self.spec, "resets", self.resets)

    # what it measures -------------------------------------------------------------------------
    def sensor_state(self) -> tuple[Pose, Array, Array]:
        """Pose of the sensor frame in the world, velocity of its origin, world axes."""
        pose, linear, angular = self.model.link_state(self.spec.link)
        if self._offset is None:
            return pose, linear, angular
        arm = pose.matrix @ np.asarray(self._offset.position)
        return pose * self._offset, linear + cross(angular, arm), angular

    def sensor_motion(self) -> tuple[Vec3, Quat, Vec3, Vec3]:
        """As sensor_state, in tuples: position, quaternion, linear and angular velocity."""
        motion = self.model.link_motion(self.spec.link)
        offset = self._offset
        if offset is None:
            return motion
        origin, rotation, linear, angular = motion
        position, orientation = compose(origin, rotation, offset.position, offset.orientation)
        return position, orientation, velocity_at(position, origin, linear, angular), angular

    def is_message(self, step: int) -> bool:
        """Whether the update of a step publishes; others count as no message."""
        return True

    def recorded(self) -> Any:
        """What update_recorded() takes, of all recorded steps; None: it cannot be called now."""
        return None

    def update_recorded(self, recorded: Any, steps: Sequence[int]) -> int:
        """As update() after each of some recorded steps; how many messages there were."""
        return 0

    def recorded_motion(self, motion: Any, steps: Sequence[int]) -> Any:
        """As sensor_motion() after recorded steps, of Model.recorded_motion() of its link."""
        chosen = self.world.recorded(steps)
        origin, rotation, linear, angular = motion = [
            [values[chosen] for values in part] for part in motion
        ]
        if self._offset is None:
            return motion
        offset = self._offset.position, self._offset.orientation
        position, orientation = compose(origin, rotation, *offset)
        return position, orientation, velocity_at(position, origin, linear, angular), angular

    def pose(self) -> Pose:
        """Pose of the sensor frame in the world."""
        return self.sensor_state()[0]


class Acting(Part):
    """Acts on its model after each step; /gazebo/reset_world leaves it as it is."""

    every_step = True
    resets = False


class Preparing(Part):
    """Acts when its model is there and after each reset alone."""

    always = False

    def needs_update(self) -> bool:
        """Never."""
        return False

    def update(self, time: float, period: float) -> None:
        """Nothing."""


class Sensor(Part):
    """Publishes what it measures while it has subscribers.

    Attributes:
        MESSAGE: type of its messages, where they have numbers alone.
        FIELDS: of them -> how many numbers, see NumbersOutput.
    """

    always = False
    reports = True
    resets = False
    MESSAGE: ClassVar[str] = ""
    FIELDS: ClassVar[Mapping[str, int]] = {}

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        output = self.make_output()
        self._sender: Any = None if output is None else self.output(output)

    def make_output(self) -> Output | None:
        """What it publishes; None: its class has made its topics."""
        frame = getattr(self.spec, "frame_id", "")
        return NumbersOutput(self.spec.topic, self.MESSAGE, self.FIELDS, frame)

    def measure(self, time: float) -> Any:
        """What it publishes for a simulated time [s], see Output.fields; None: nothing."""
        raise NotImplementedError

    def update(self, time: float, period: float) -> None:
        values = self.measure(time)
        if values is not None:
            self._sender.send(time, *values)

    def measure_recorded(self, recorded: Any, steps: Sequence[int]) -> Any:
        """As measure() after each of k recorded steps: sequences of arrays (k,)."""
        raise NotImplementedError

    def update_recorded(self, recorded: Any, steps: Sequence[int]) -> int:
        values = self.measure_recorded(recorded, steps)
        self._sender.send_all(self.world.times(steps), *values)
        return len(steps)

    def go_back(self, time: float) -> None:
        """As of a Part; one that measures in every step does not wait."""
        if self._asked > 0.0:
            super().go_back(time)
        else:
            self.restart(time)
