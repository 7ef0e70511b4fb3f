"""ros_control's face of one robot: controller_manager services and command topics."""

import math
import threading

import rospy
from controller_manager_msgs.msg import ControllerState, HardwareInterfaceResources
from controller_manager_msgs.srv import (
    ListControllers, ListControllersResponse, ListControllerTypes, ListControllerTypesResponse,
    LoadController, LoadControllerResponse, ReloadControllerLibraries,
    ReloadControllerLibrariesResponse, SwitchController, SwitchControllerRequest,
    SwitchControllerResponse, UnloadController, UnloadControllerResponse)
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from bullet_bridge import conversions
from bullet_bridge.schedule import Schedule
from bullet_sim.errors import ControllerError, SimError


class RobotControl:
    """Controllers of one model.

    Args:
        jobs: JobQueue of the simulation thread.
        world, model: of the core.
        namespace: e.g. '/racecar'.
    """

    def __init__(self, jobs, world, model, namespace):
        self._jobs, self._world, self._model = jobs, world, model
        self.namespace = '/' + namespace.strip('/') if namespace.strip('/') else ''
        self._manager = model.manager
        self._mail, self._lock = {}, threading.Lock()
        self._subscribers, self._state_schedules, self._said = {}, {}, set()
        self._joint_states = rospy.Publisher(f'{self.namespace}/joint_states', JointState,
                                             queue_size=10)
        self._services = [rospy.Service(f'{self.namespace}/controller_manager/{name}', kind, do)
                          for name, kind, do in (
                              ('load_controller', LoadController, self._load),
                              ('unload_controller', UnloadController, self._unload),
                              ('switch_controller', SwitchController, self._switch),
                              ('list_controllers', ListControllers, self._list),
                              ('list_controller_types', ListControllerTypes, self._types),
                              ('reload_controller_libraries', ReloadControllerLibraries,
                               self._reload))]

    # simulation thread ------------------------------------------------------------------------
    def deliver(self):
        """Hand over the latest commands."""
        if not self._mail:
            return
        with self._lock:
            mail, self._mail = self._mail, {}
        for name, values in mail.items():
            try:
                self._manager.command(name, values)
            except SimError as error:
                rospy.logerr_throttle(1.0, f'{self.namespace}: {error}')

    def next_due(self):
        """First physics step after which joint states are to be published, or infinity."""
        return min((self._schedule(spec).next
                    for spec in self._manager.running_state_controllers()), default=math.inf)

    def _schedule(self, spec):
        schedule = self._state_schedules.get(spec.name)
        if schedule is None:
            schedule = Schedule(spec.publish_rate, self._world.time_step, self._world.step_count)
            self._state_schedules[spec.name] = schedule
        return schedule

    def publish(self, step, time):
        """Publish joint states that are due."""
        for spec in self._manager.running_state_controllers():
            if self._schedule(spec).due(step) and self._joint_states.get_num_connections() > 0:
                self._joint_states.publish(conversions.joint_state(
                    time, self._model.joints.names, *self._model.joints.read()))

    def restart(self):
        """Start afresh after a reset."""
        with self._lock:
            self._mail = {}
        self._state_schedules = {}

    # service threads --------------------------------------------------------------------------
    def _accept(self, name):
        def callback(message):
            data = message.data
            with self._lock:
                self._mail[name] = (data,) if isinstance(data, float) else tuple(data)
        return callback

    def _load(self, request):
        name = request.name.strip('/')
        config = rospy.get_param(f'{self.namespace}/{name}', None)
        if config is None:
            rospy.logerr("%s: controller '%s' has no parameters: %s/%s is not on the parameter "
                         'server', self.namespace, name, self.namespace, name)
            return LoadControllerResponse(ok=False)
        spec = self._answer(lambda: self._check_rate(self._manager.load(name, config)))
        if spec is None:
            return LoadControllerResponse(ok=False)
        for note in spec.notes:
            self._say_once(spec.kind.type, note)
        if spec.kind.interface != 'state':
            kind = Float64MultiArray if spec.kind.group else Float64
            self._subscribers[name] = rospy.Subscriber(
                f'{self.namespace}/{name}/command', kind, self._accept(name), queue_size=1,
                tcp_nodelay=True)
        return LoadControllerResponse(ok=True)

    def _check_rate(self, spec):
        if spec.kind.interface == 'state' and spec.publish_rate * self._world.time_step > 1:
            self._manager.unload(spec.name)
            raise ControllerError(f"controller '{spec.name}' publish_rate is "
                                  f'{spec.publish_rate}, must be at most '
                                  f'{1 / self._world.time_step:g} Hz, one per physics step')
        return spec

    def _say_once(self, key, text):
        if key not in self._said:
            self._said.add(key)
            rospy.loginfo('%s: %s', self.namespace, text)

    def _unload(self, request):
        name = request.name.strip('/')
        done = self._answer(lambda: self._manager.unload(name) or True)
        subscriber = self._subscribers.pop(name, None) if done else None
        if subscriber is not None:
            subscriber.unregister()
        return UnloadControllerResponse(ok=bool(done))

    def _switch(self, request):
        strict = request.strictness != SwitchControllerRequest.BEST_EFFORT
        left_out = self._answer(lambda: self._manager.switch(
            request.start_controllers, request.stop_controllers, strict))
        if left_out is None:
            return SwitchControllerResponse(ok=False)
        for reason in left_out:
            rospy.logwarn('%s: %s', self.namespace, reason)
        return SwitchControllerResponse(ok=True)

    def _list(self, _):
        response = ListControllersResponse()
        for spec, state in self._answer(self._manager.list) or []:
            resources = HardwareInterfaceResources(
                hardware_interface=spec.kind.hardware_interface,
                resources=[] if spec.kind.interface == 'state' else list(spec.joints))
            response.controller.append(ControllerState(
                name=spec.name, state=state, type=spec.kind.type,
                claimed_resources=[resources]))
        return response

    def _types(self, _):
        types = self._manager.types()
        return ListControllerTypesResponse(types=types,
                                           base_classes=['controller_interface'] * len(types))

    def _reload(self, _):
        return ReloadControllerLibrariesResponse(ok=True)

    def _answer(self, work):
        """Result of a job, or None with the reason in the log."""
        try:
            return self._jobs.call(work)
        except (SimError, TimeoutError) as error:
            rospy.logerr('%s: %s', self.namespace, error)
            return None

    def close(self):
        """Withdraw services and topics."""
        for service in self._services:
            service.shutdown('model deleted')
        for subscriber in self._subscribers.values():
            subscriber.unregister()
        self._joint_states.unregister()
