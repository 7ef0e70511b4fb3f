"""The services below /gazebo that ordinary clients of gazebo_ros call."""

import rospy
from gazebo_msgs.srv import (
    DeleteModel, DeleteModelResponse, GetModelProperties, GetModelPropertiesResponse,
    GetModelState, GetModelStateResponse, GetWorldProperties, GetWorldPropertiesResponse,
    SetModelState, SetModelStateResponse, SpawnModel, SpawnModelResponse)
from std_srvs.srv import Empty, EmptyResponse

from bullet_bridge.conversions import pose_from_msg, pose_to_msg, stamp, twist_to_msg
from bullet_sim.errors import SimError
from bullet_sim.pose import Pose

WORLD_FRAMES = ('', 'world', 'map', '/world', '/map')


class GazeboServices:
    """Spawning, deleting, moving and asking models; pausing and resetting.

    Args:
        world: of the core.
        jobs: JobQueue of the simulation thread.
        robots: Robots.
        server: Server.
        resolve: function URI -> path.
    """

    def __init__(self, world, jobs, robots, server, resolve):
        self._world, self._jobs, self._robots = world, jobs, robots
        self._server, self._resolve = server, resolve
        for name, kind, work in (
                ('spawn_urdf_model', SpawnModel, lambda r: self._spawn(r, world.spawn_urdf)),
                ('spawn_sdf_model', SpawnModel, lambda r: self._spawn(r, world.spawn_sdf)),
                ('delete_model', DeleteModel, self._delete),
                ('get_model_state', GetModelState, self._get_state),
                ('set_model_state', SetModelState, self._set_state),
                ('get_world_properties', GetWorldProperties, self._get_world),
                ('get_model_properties', GetModelProperties, self._get_properties)):
            rospy.Service(f'/gazebo/{name}', kind, self._answering(work, kind))
        for name, work in (('pause_physics', lambda: server.set_paused(True)),
                           ('unpause_physics', lambda: server.set_paused(False)),
                           ('reset_simulation', lambda: server.reset(time=True)),
                           ('reset_world', lambda: server.reset(time=False))):
            rospy.Service(f'/gazebo/{name}', Empty, self._commanding(work))

    @staticmethod
    def _answering(work, kind):
        """Handler: an error becomes success=False with the reason, once in the log."""
        def handle(request):
            try:
                response = work(request)
                response.success = True
                return response
            except (SimError, TimeoutError) as error:
                rospy.logerr('%s', error)
                return kind._response_class(success=False, status_message=str(error))
        return handle

    def _commanding(self, work):
        def handle(_):
            self._jobs.call(work)
            return EmptyResponse()
        return handle

    def _spawn(self, request, spawn):
        pose = pose_from_msg(request.initial_pose)

        def work():
            return spawn(request.model_name, request.model_xml,
                         self._frame(request.reference_frame) * pose, self._resolve)
        model = self._jobs.call(work)
        self._robots.connect(model, request.robot_namespace)
        return SpawnModelResponse(status_message=f"spawned '{model.name}'")

    def _frame(self, name):
        """World pose of a reference frame: world, a model, or model::link."""
        if name in WORLD_FRAMES:
            return Pose()
        model, _, link = name.partition('::')
        if not link:
            return self._world.model(model).pose
        return self._world.model(model).link_state(link)[0]

    def _delete(self, request):
        def work():
            self._world.delete(request.model_name)
            return self._robots.disconnect(request.model_name)
        for part in self._jobs.call(work):
            part.close()
        return DeleteModelResponse(status_message=f"deleted '{request.model_name}'")

    def _get_state(self, request):
        def work():
            model = self._world.model(request.model_name)
            pose, linear, angular = model.link_state(model.description.root)
            frame = self._frame(request.relative_entity_name)
            turn = frame.inverse()
            return (self._world.time, turn * pose, turn.matrix @ linear, turn.matrix @ angular)
        time, pose, linear, angular = self._jobs.call(work)
        response = GetModelStateResponse(pose=pose_to_msg(pose),
                                         twist=twist_to_msg(linear, angular))
        response.header.stamp = stamp(time)
        response.header.frame_id = request.relative_entity_name
        return response

    def _set_state(self, request):
        state = request.model_state
        linear = [getattr(state.twist.linear, axis) for axis in 'xyz']
        angular = [getattr(state.twist.angular, axis) for axis in 'xyz']

        def work():
            frame = self._frame(state.reference_frame)
            self._world.model(state.model_name).set_state(
                frame * pose_from_msg(state.pose), frame.matrix @ linear,
                frame.matrix @ angular)
        self._jobs.call(work)
        return SetModelStateResponse(status_message=f"moved '{state.model_name}'")

    def _get_world(self, _):
        time, names = self._jobs.call(lambda: (self._world.time, list(self._world.models)))
        return GetWorldPropertiesResponse(sim_time=time, model_names=names,
                                          rendering_enabled=True)

    def _get_properties(self, request):
        model = self._jobs.call(lambda: self._world.model(request.model_name))
        return GetModelPropertiesResponse(
            canonical_body_name=model.description.root, body_names=list(model.link_names),
            joint_names=list(model.joints.names), is_static=model.is_static)
