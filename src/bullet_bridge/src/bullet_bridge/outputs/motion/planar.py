"""libgazebo_ros_planar_move: a model that follows its velocity commands exactly."""

import math

from bullet_sim.sensors import inertial
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from paddock_common.odometry import transform_of
from tf2_msgs.msg import TFMessage

from bullet_bridge.loop.schedule import Schedule
from bullet_bridge.outputs.motion.wheels import command_of, odometry_message
from bullet_bridge.outputs.sensors import Output
from bullet_bridge.transport.publishing import publisher


class PlanarMoveOutput(Output):
    """Sets the model's velocity in every step; publishes Odometry and its transform.

    Upstream sets the vertical velocity and the others of rotation to zero, so does this.
    """

    message = Odometry
    every_step = True

    def __init__(self, world, model, spec, seed):
        super().__init__(world, model, spec, seed)
        self._transform = publisher("/tf", TFMessage)
        self._subscriber = None

    def attach(self, arrivals):
        self._subscriber = arrivals.subscribe(self.spec.command_topic, Twist, self._on_command)

    def restart(self):
        super().restart()
        self._command, self._since, self._new = (0.0, 0.0, 0.0), None, False
        rate = min(self.spec.rate, 1.0 / self.world.time_step)
        self._odometry = Schedule(rate, self.world.time_step, self.world.step_count)

    def has_subscribers(self):
        """True: the model is moved with and without subscribers."""
        return True

    def _on_command(self, message):
        command = command_of(
            self.spec.command_topic, (message.linear.x, message.linear.y, message.angular.z)
        )
        if command is not None:
            self._command, self._new = command, True

    def update(self, time):
        if self._new:
            self._since, self._new = time, False
        if 0.0 <= self.spec.timeout < time - (time if self._since is None else self._since):
            self._command = (0.0, 0.0, 0.0)
        pose, linear, angular = self.model.link_state(self.spec.link)
        x, y, turn = self._command
        yaw = pose.rpy[2]
        c, s = math.cos(yaw), math.sin(yaw)
        self.world.engine.set_base_velocity(
            self.model.body, (c * x - s * y, s * x + c * y, 0.0), (0.0, 0.0, turn)
        )
        if self._odometry.due(self.world.step_count):
            self._publish(time, pose, linear, angular)

    def _publish(self, time, pose, linear, angular):
        linear, angular = inertial.twist(pose.orientation, linear, angular)
        message = odometry_message(time, self.spec, pose, linear, angular)
        self.publisher.publish(message)
        self._transform.publish(TFMessage([transform_of(message)]))

    def close(self):
        super().close()
        self._transform.unregister()
        if self._subscriber is not None:
            self._subscriber.unregister()
