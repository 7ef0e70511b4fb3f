"""Controllers that publish a robot's sensors: IMUs, force and torque of joints."""

import zlib
from dataclasses import replace

from bullet_sim.plugins.forces import ForceTorqueSpec
from bullet_sim.plugins.inertial import ImuSpec

from bullet_bridge.control.topics import Topics
from bullet_bridge.outputs.table import OUTPUTS

_KINDS = {"imu": ImuSpec, "force_torque": ForceTorqueSpec}


class Sensors(Topics):
    """Each sensor of a kind on a topic of its own name in the robot's namespace.

    A joint's sensor has the joint's name.
    """

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._outputs = []
        for found in robot.model.description.sensors:
            if type(found) is not _KINDS[spec.kind.interface]:
                continue
            name = getattr(found, "joint", found.name)
            wanted = replace(found, topic=f"{robot.namespace}/{name}", rate=spec.publish_rate)
            seed = zlib.crc32(f"{spec.name}/{name}".encode())
            output = OUTPUTS[type(found)](robot.world, robot.model, wanted, seed)
            self._outputs.append(output)
            self.schedules.append(output.schedule)

    def publish(self, step, time):
        """Publish the sensors that are due."""
        for output in self._outputs:
            if output.schedule.due(step):
                output.update(time)

    def restart(self, step):
        """Restart schedules and noise."""
        for output in self._outputs:
            output.restart()

    def close(self):
        """Unregister the topics."""
        for output in self._outputs:
            output.close()
        super().close()
