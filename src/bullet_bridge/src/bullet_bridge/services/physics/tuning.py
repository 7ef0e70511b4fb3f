"""The physics' properties through dynamic_reconfigure, as in gazebo_ros."""

import rospy
from bullet_sim.errors import SimError
from dynamic_reconfigure.server import Server

from bullet_bridge.services.physics import config as physics_config
from bullet_bridge.services.physics.properties import FIXED

AXES = ("gravity_x", "gravity_y", "gravity_z")


def as_config(properties):
    """dict of physics_config's names with the values of Properties."""
    return dict(
        FIXED,
        time_step=properties.time_step,
        max_update_rate=properties.max_update_rate,
        sor_pgs_iters=properties.iterations,
        **dict(zip(AXES, properties.gravity)),
    )


def wanted_changes(config, before):
    """Arguments for PhysicsProperties.change: what differs from the configuration before."""
    changes = {
        name: config[name]
        for name in ("time_step", "max_update_rate")
        if config[name] != before[name]
    }
    if any(config[axis] != before[axis] for axis in AXES):
        changes["gravity"] = tuple(config[axis] for axis in AXES)
    if config["sor_pgs_iters"] != before["sor_pgs_iters"]:
        changes["iterations"] = config["sor_pgs_iters"]
    return changes


class _Server(Server):
    """A server whose first values are the world's, not those of the parameter server."""

    def __init__(self, values, callback, namespace):
        self._values = values
        super().__init__(physics_config, callback, namespace)

    def _copy_from_parameter_server(self):
        self.config.update(self._values)


class PhysicsTuning:
    """dynamic_reconfigure server of the world; to be created before the simulation runs.

    Args:
        namespace: of its service, topics and parameters.
        jobs: JobQueue of the simulation thread.
        properties: PhysicsProperties.
    """

    def __init__(self, namespace, jobs, properties):
        self._jobs, self._properties = jobs, properties
        self._last = as_config(properties.read())
        self._started = False
        self._server = _Server(self._last, self._changed, namespace)
        self._started = True

    def _changed(self, config, _level):
        if not self._started:
            return config
        changes = wanted_changes(config, self._last)
        try:
            self._jobs.call(lambda: self._properties.change(**changes))
        except (SimError, TimeoutError) as error:
            rospy.logerr("physics properties: %s", error)
        try:
            self._last = as_config(self._jobs.call(self._properties.read))
        except TimeoutError as error:
            rospy.logerr("physics properties: %s", error)
        config.update(self._last)
        return config
