"""What a spawned model brings to the ROS graph: controllers and sensors."""

import math
import zlib

import rospy

from bullet_bridge.arrivals import Arrivals
from bullet_bridge.control import RobotControl
from bullet_bridge.outputs import OUTPUTS
from bullet_bridge.sensor_outputs import CameraOutput


class Robots:
    """Controls and sensor outputs of all models.

    Args:
        jobs: JobQueue of the simulation thread.
        world: of the core.
        cameras: Cameras.
        seed: base of all noise seeds.
        arrivals: Arrivals, which count the commands.

    The loop asks next_due and publish in every batch, so what they need is kept as flat lists and
    one number; `refresh` renews them after anything may have changed.
    """

    def __init__(self, jobs, world, cameras, seed, arrivals=None):
        self._jobs, self._world, self._cameras, self._seed = jobs, world, cameras, seed
        self.arrivals = arrivals or Arrivals()
        self._controls, self._outputs, self._counts = {}, {}, {}
        self._all_controls, self._all_outputs, self._next = (), (), math.inf

    def connect(self, model, namespace=''):
        """Offer a model's services and topics; called outside the simulation thread."""
        for text in model.description.warnings:
            rospy.logwarn("model '%s': %s", model.name, text)
        self._offer(model, namespace, self._jobs.call)

    def adopt(self):
        """Offer what the world file's models bring; called before the simulation runs."""
        for model in list(self._world.models.values()):
            if model.description.sensors or model.manager is not None:
                self._offer(model, '', lambda job: job())

    def _offer(self, model, namespace, run):
        outputs = []
        for number, spec in enumerate(model.description.sensors):
            seed = zlib.crc32(f'{self._seed}/{model.name}/{number}'.encode())
            try:
                output = OUTPUTS[type(spec)](self._world, model, spec, seed)
            except ValueError as error:
                rospy.logerr("model '%s': sensor on %s is left out: %s", model.name,
                             spec.topic, error)
                continue
            output.attach(self.arrivals)
            outputs.append(output)
            if isinstance(output, CameraOutput):
                self._cameras.add(output)
        if any(isinstance(output, CameraOutput) for output in outputs):
            self._cameras.start()
        control = self._control(model, namespace)

        def register():
            if self._world.models.get(model.name) is not model:
                return False
            for output in outputs:      # steps were made since they were built
                output.schedule.restart(self._world.step_count)
            self._outputs[model.name] = outputs
            if control is not None:
                self._controls[model.name] = control
            self._cameras.set_sources(self._world.sources())
            self.refresh()
            return True
        if not run(register):   # deleted by somebody meanwhile
            for part in ([control] if control is not None else []) + outputs:
                part.close()

    def _control(self, model, namespace):
        """The model's RobotControl; None without a control plugin, or if its place is taken."""
        if model.manager is None:
            return None
        namespace = (model.description.control_namespace or namespace or model.name).strip('/')
        rival = next((name for name, control in self._controls.items()
                      if control.namespace.strip('/') == namespace), None)
        if rival is None:
            return RobotControl(self._jobs, self._world, model, namespace, self.arrivals)
        rospy.logerr("model '%s' has no controllers: '%s' has its controller_manager in the "
                     "namespace '/%s' already; give each a robot_namespace", model.name, rival,
                     namespace)
        return None

    def disconnect(self, name):
        """Withdraw a model's services and topics (simulation thread)."""
        control = self._controls.pop(name, None)
        outputs = self._outputs.pop(name, [])
        for output in outputs:
            self._counts.pop(output, None)
            if isinstance(output, CameraOutput):
                self._cameras.remove(output)
        self._cameras.set_sources(self._world.sources())
        self.refresh()
        return ([control] if control is not None else []) + outputs

    def refresh(self):
        """Look again at what there is and when it is due (simulation thread, after jobs)."""
        self._all_controls = tuple(self._controls.values())
        self._all_outputs = tuple(output for outputs in self._outputs.values()
                                  for output in outputs)
        self._look_ahead()

    def _look_ahead(self):
        due = [output.schedule.next for output in self._all_outputs]
        due += [control.next_due() for control in self._all_controls]
        self._next = min(due, default=math.inf)

    def deliver(self):
        """Hand over the latest commands of all robots."""
        for control in self._all_controls:
            control.deliver()

    def next_due(self):
        """First physics step after which something is to be published, or infinity."""
        return self._next

    def publish(self, step, time):
        """Publish whatever is due at this step and listened to."""
        if step < self._next:
            return
        for control in self._all_controls:
            control.publish(step, time)
        pictures = []
        for output in self._all_outputs:
            if output.schedule.due(step) and output.listened():
                self._counts[output] = self._counts.get(output, 0) + 1
                if isinstance(output, CameraOutput):
                    pictures.append(output)
                else:
                    output.update(time)
        if pictures:
            self._cameras.draw(self._world, pictures)
        self._look_ahead()

    def sensor_counts(self):
        """Messages so far of each sensor that had listeners, by WORLD::MODEL::LINK::SENSOR."""
        return {f'{self._world.name}::{output.model.name}::{output.spec.link}::'
                f"{getattr(output.spec, 'name', output.spec.topic)}": count
                for output, count in self._counts.items()}

    def take_failures(self):
        """What of the due messages could not be made since the last call, as sentences."""
        return self._cameras.take_failures()

    def restart(self):
        """Start afresh after a reset."""
        for control in self._controls.values():
            control.restart()
        for outputs in self._outputs.values():
            for output in outputs:
                output.restart()
        self._cameras.set_sources(self._world.sources())
        self.refresh()
