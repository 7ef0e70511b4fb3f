"""Services about physics and time: pause, reset, properties."""

import rospy
from gazebo_msgs.msg import ODEPhysics
from gazebo_msgs.srv import (
    GetPhysicsProperties,
    GetPhysicsPropertiesResponse,
    SetPhysicsProperties,
    SetPhysicsPropertiesResponse,
)
from geometry_msgs.msg import Vector3
from std_srvs.srv import Empty

from bullet_bridge.services.handlers import empty_service_handler, service_handler
from bullet_bridge.services.physics.properties import FIXED
from bullet_bridge.transport.conversions import vector


class PhysicsServices:
    """Pausing, resetting, gravity, step and pace.

    Args:
        prefix: of the service names.
        jobs: JobQueue of the simulation thread.
        server: Server.
        properties: PhysicsProperties.
    """

    def __init__(self, prefix, jobs, server, properties):
        self._jobs, self._server, self._properties = jobs, server, properties
        for name, work in (
            ("pause_physics", lambda: server.set_paused(True)),
            ("unpause_physics", lambda: server.set_paused(False)),
            ("reset_simulation", lambda: server.reset(time=True)),
            ("reset_world", lambda: server.reset(time=False)),
        ):
            rospy.Service(
                f"{prefix}/{name}",
                Empty,
                empty_service_handler(lambda _, work=work: jobs.call(work)),
            )
        for name, kind, work in (
            ("get_physics_properties", GetPhysicsProperties, self._get),
            ("set_physics_properties", SetPhysicsProperties, self._set),
        ):
            rospy.Service(f"{prefix}/{name}", kind, service_handler(work, kind))

    def _get(self, _):
        now = self._jobs.call(self._properties.read)
        return GetPhysicsPropertiesResponse(
            time_step=now.time_step,
            pause=self._server.paused,
            max_update_rate=now.max_update_rate,
            gravity=Vector3(*now.gravity),
            ode_config=ODEPhysics(sor_pgs_iters=now.iterations, **FIXED),
            status_message="got the properties",
        )

    def _set(self, request):
        config = request.ode_config
        self._jobs.call(
            lambda: self._properties.change(
                time_step=request.time_step,
                max_update_rate=request.max_update_rate,
                gravity=tuple(vector(request.gravity).tolist()),
                iterations=config.sor_pgs_iters,
            )
        )
        others = [
            name
            for name, value in FIXED.items()
            if getattr(config, name) not in (value, type(value)())
        ]
        text = "physics properties set"
        if others:
            text += f"; ignored, settings of the engine ODE: {', '.join(others)}"
        return SetPhysicsPropertiesResponse(status_message=text)
