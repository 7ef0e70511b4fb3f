"""Makes and closes what a model has in the ROS graph: its controllers and sensors' outputs."""

import threading
import zlib

import rospy

from bullet_bridge.control.robot import RobotControl
from bullet_bridge.outputs.sensors import CameraOutput
from bullet_bridge.outputs.table import CAMERAS, OUTPUTS
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
