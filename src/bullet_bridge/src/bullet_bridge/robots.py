"""What a spawned model brings to the ROS graph: controllers and sensors."""

import math
import zlib

import rospy

from bullet_bridge.control import RobotControl
from bullet_bridge.sensor_outputs import OUTPUTS, CameraOutput


class Robots:
    """Controls and sensor outputs of all models.

    Args:
        jobs: JobQueue of the simulation thread.
        world: of the core.
        cameras: Cameras.
        seed: base of all noise seeds.
    """

    def __init__(self, jobs, world, cameras, seed):
        self._jobs, self._world, self._cameras, self._seed = jobs, world, cameras, seed
        self._controls, self._outputs = {}, {}

    def connect(self, model, namespace=''):
        """Offer a model's services and topics; called outside the simulation thread."""
        for text in model.description.warnings:
            rospy.logwarn("model '%s': %s", model.name, text)
        outputs = []
        for number, spec in enumerate(model.description.sensors):
            seed = zlib.crc32(f'{self._seed}/{model.name}/{number}'.encode())
            try:
                output = OUTPUTS[type(spec)](self._world, model, spec, seed)
            except ValueError as error:
                rospy.logerr("model '%s': sensor on %s is left out: %s", model.name,
                             spec.topic, error)
                continue
            outputs.append(output)
            if isinstance(output, CameraOutput):
                self._cameras.add(output)
        if any(isinstance(output, CameraOutput) for output in outputs):
            self._cameras.start()
        control = None
        if model.manager is not None:
            namespace = model.description.control_namespace or namespace
            control = RobotControl(self._jobs, self._world, model, namespace)

        def register():
            self._outputs[model.name] = outputs
            if control is not None:
                self._controls[model.name] = control
            self._cameras.set_sources(self._world.sources())
        self._jobs.call(register)

    def disconnect(self, name):
        """Withdraw a model's services and topics (simulation thread)."""
        control = self._controls.pop(name, None)
        outputs = self._outputs.pop(name, [])
        for output in outputs:
            if isinstance(output, CameraOutput):
                self._cameras.remove(output)
        self._cameras.set_sources(self._world.sources())
        return ([control] if control is not None else []) + outputs

    def deliver(self):
        """Hand over the latest commands of all robots."""
        for control in self._controls.values():
            control.deliver()

    def next_due(self):
        """First physics step after which something is to be published, or infinity."""
        due = [output.schedule.next for outputs in self._outputs.values() for output in outputs]
        due += [control.next_due() for control in self._controls.values()]
        return min(due, default=math.inf)

    def publish(self, step, time):
        """Publish whatever is due at this step and listened to."""
        for control in self._controls.values():
            control.publish(step, time)
        pictures = []
        for outputs in self._outputs.values():
            for output in outputs:
                if output.schedule.due(step) and output.listened():
                    if isinstance(output, CameraOutput):
                        pictures.append(output)
                    else:
                        output.update(time)
        if pictures:
            self._cameras.draw(self._world, pictures)

    def restart(self):
        """Start afresh after a reset."""
        for control in self._controls.values():
            control.restart()
        for outputs in self._outputs.values():
            for output in outputs:
                output.restart()
        self._cameras.set_sources(self._world.sources())
