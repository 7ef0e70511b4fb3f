"""The models of the world as ROS sees them: connected, updated, published, disconnected."""

import threading
import time as wall
import zlib

import rospy

from bullet_bridge.control.robot import RobotControl
from bullet_bridge.loop.received import Arrivals
from bullet_bridge.plugins.cameras import CameraOutput
from bullet_bridge.plugins.table import CAMERAS, OUTPUTS
from bullet_bridge.resolve import log_warnings
from bullet_bridge.transport.publishing import all_or_none


class Connector:
    """Makes controls and outputs of models, outside the simulation thread.

    Args:
        jobs: JobQueue of the simulation thread.
        world: of the core.
        cameras: Cameras.
        seed: base of all noise seeds.
        arrivals: Arrivals, which count the commands.
    """

    def __init__(self, jobs, world, cameras, seed, arrivals):
        self._jobs, self._world, self._cameras, self._seed = jobs, world, cameras, seed
        self._arrivals = arrivals
        self._claims, self._claiming = {}, threading.Lock()  # control namespace -> model

    def make_outputs(self, model, outputs):
        """Append the outputs of a model's sensors to a list, except those that fail."""
        if any(type(spec) in CAMERAS for spec in model.description.sensors):
            self._cameras.start()
        for number, spec in enumerate(model.description.sensors):
            seed = zlib.crc32(f"{self._seed}/{model.name}/{number}".encode())
            try:
                with all_or_none():
                    output = OUTPUTS[type(spec)](self._world, model, spec, seed)
                    output.attach(self._arrivals)
            except (ValueError, ArithmeticError) as error:
                rospy.logerr(
                    "model '%s': sensor on %s is left out: %s", model.name, spec.topic, error
                )
                continue
            outputs.append(output)
            if isinstance(output, CameraOutput):
                self._cameras.add(output)

    def close(self, parts):
        """Close parts of a failed spawn; if one raises, the others are closed all the same."""
        for part in parts:
            if isinstance(part, CameraOutput):
                self._cameras.remove(part)
            try:
                part.close()
            except Exception as error:
                rospy.logerr("a part of a failed spawn cannot be closed: %s", error)
            if isinstance(part, RobotControl):
                self.release(part.model)

    def make_control(self, model, namespace):
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
            return RobotControl(self._jobs, self._world, model, namespace, self._arrivals)
        except rospy.ServiceException as error:
            self.release(model)
            rospy.logerr("model '%s' has no controllers: %s", model.name, error)
            return None
        except BaseException:
            self.release(model)
            raise

    def release(self, model):
        """Release a model's control namespace for other models; of any thread."""
        with self._claiming:
            self._claims = {
                namespace: owner for namespace, owner in self._claims.items() if owner is not model
            }


CHECK_PERIOD = 0.02  # [s] of simulated time between two checks for subscribers ...
CHECK_GAP = 0.005  # [s] ... and least wall time between them


def _publish(what, publish, *arguments):
    """Publish; if a state is NaN or infinite, log that it cannot be published."""
    try:
        publish(*arguments)
    except (ValueError, ArithmeticError) as error:
        rospy.logerr_throttle(5.0, f"{what}: cannot be published: {error}")


class Robots:
    """Controls and sensor outputs of all models.

    Args:
        jobs, world, cameras, seed, arrivals: as Connector's.

    The loop calls next_due and publish in every batch, so what they use is stored as flat lists and
    one number; `refresh` updates them after jobs.
    """

    def __init__(self, jobs, world, cameras, seed, arrivals=None):
        self._jobs, self._world, self._cameras = jobs, world, cameras
        self.arrivals = arrivals or Arrivals()
        self._connector = Connector(jobs, world, cameras, seed, self.arrivals)
        self._controls, self._outputs, self._counts = {}, {}, {}
        self._all_controls, self._all_outputs, self._next, self._next_check = (), (), 0, 0.0

    def connect(self, model, namespace=""):
        """Create a model's services and topics; called outside the simulation thread."""
        log_warnings(model.description.warnings, model.name)
        self._connect(model, namespace, self._jobs.call)

    def connect_world_models(self):
        """Connect the models of the world file; called before the simulation runs."""
        for model in list(self._world.models.values()):
            if model.description.sensors or model.manager is not None:
                self._connect(model, "", lambda job: job())

    def _connect(self, model, namespace, run):
        outputs, controls = [], []

        def register():
            if self._world.models.get(model.name) is not model:
                return False
            for output in outputs:  # steps were made since they were created
                output.schedule.restart(self._world.step_count)
            self._outputs[model.name] = outputs
            for control in controls:
                self._controls[model.name] = control
            self._cameras.set_sources(self._world.sources())
            self.refresh()
            return True

        registered = False
        try:
            self._connector.make_outputs(model, outputs)
            control = self._connector.make_control(model, namespace)
            controls += [control] if control is not None else []
            registered = run(register)  # False: the model was deleted in the meantime
        finally:
            if not registered:
                self._connector.close(controls + outputs)

    def disconnect(self, name):
        """Remove a model (simulation thread).

        Returns:
            Its controls and outputs, which the caller closes.
        """
        control = self._controls.pop(name, None)
        if control is not None:
            control.closed = True
            self._connector.release(control.model)
        outputs = self._outputs.pop(name, [])
        for output in outputs:
            self._counts.pop(output, None)
            if isinstance(output, CameraOutput):
                self._cameras.remove(output)
        self._cameras.set_sources(self._world.sources())
        self.refresh()
        return ([control] if control is not None else []) + outputs

    def refresh(self):
        """Update the flat lists and the next due step (simulation thread, after jobs)."""
        self._all_controls = tuple(self._controls.values())
        for control in self._all_controls:
            control.refresh()
        self._all_outputs = tuple(
            output for outputs in self._outputs.values() for output in outputs
        )
        self._update_next(check=True)

    def _update_next(self, check=False):
        step, now = self._world.step_count, wall.monotonic()
        check = check or now >= self._next_check
        if check:
            self._next_check = now + CHECK_GAP
        due = step + max(1, round(CHECK_PERIOD / self._world.time_step))
        for output in self._all_outputs:
            due = min(due, output.schedule.next_due_subscribed(step, check))
        for control in self._all_controls:
            due = min(due, control.next_due(check))
        self._next = due

    def apply_commands(self):
        """Pass the latest commands of all robots to their controllers."""
        for control in self._all_controls:
            control.apply_commands()

    def next_due(self):
        """Physics step after which publish() has to be called at the latest."""
        return self._next

    def publish(self, step, time):
        """Publish what is due at this step and has subscribers."""
        if step < self._next:
            return
        for control in self._all_controls:
            _publish(f"controllers in '{control.namespace}'", control.publish, step, time)
        pictures = []
        for output in self._all_outputs:
            if output.schedule.due(step):
                self._counts[output] = self._counts.get(output, 0) + 1
                if isinstance(output, CameraOutput):
                    pictures.append(output)
                else:
                    _publish(
                        f"model '{output.model.name}', sensor on {output.spec.topic}",
                        output.update,
                        time,
                    )
        if pictures:
            _publish("pictures", self._cameras.draw, self._world, pictures)
        self._update_next()

    def parts(self, name):
        """Outputs (a list) and RobotControl, or None, of a model."""
        return list(self._outputs.get(name, ())), self._controls.get(name)

    def sensor_counts(self):
        """Messages so far of each sensor with subscribers, by WORLD::MODEL::LINK::SENSOR."""
        return {
            f"{self._world.name}::{output.model.name}::{output.spec.link}::"
            f"{getattr(output.spec, 'name', output.spec.topic)}": count
            for output, count in self._counts.items()
        }

    def take_failures(self):
        """Sentences about due messages that could not be made since the last call."""
        return self._cameras.take_failures()

    def show_scene(self):
        """Let the pictures show the world's present lights."""
        self._cameras.set_sources(self._world.sources())

    def save_state(self):
        """State of sensors and plugins, and the commands that wait for the next step."""
        outputs = [(each, each.get_state()) for each in self._all_outputs]
        commands = [(control, control.waiting_commands()) for control in self._controls.values()]
        return outputs, commands

    def restore_state(self, state):
        """Restore the result of save_state() of the same models, after a restart()."""
        outputs, commands = state
        for output, saved in outputs:
            output.set_state(saved)
        for control, waiting in commands:
            for name, values in waiting.items():
                control.buffer_command(name, values)
        self.refresh()

    def restart(self):
        """Restart controls, outputs and cameras after a reset."""
        for control in self._controls.values():
            control.restart()
        for outputs in self._outputs.values():
            for output in outputs:
                output.restart()
        self.arrivals.clear()  # the commands are dropped
        self._cameras.restart()
        self._cameras.set_sources(self._world.sources())
        self.refresh()
