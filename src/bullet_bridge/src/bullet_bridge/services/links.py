"""Services about links and joints: state, properties, wrenches and efforts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import rospy
from bullet_sim.errors import ModelError, SimError
from bullet_sim.models import changes
from bullet_sim.models.changes import step_range
from bullet_sim.pose import PLACEABLE, Array, Pose
from gazebo_msgs import srv
from gazebo_msgs.msg import LinkState
from geometry_msgs.msg import Pose as PoseMsg

from bullet_bridge.services.entities import WORLD_FRAMES, find_frame, find_joint, find_link
from bullet_bridge.services.handlers import (
    NO_FRAME,
    empty_service_handler,
    refusing,
    service_handler,
    topic_callback,
)
from bullet_bridge.transport.conversions import pose_from_msg, pose_to_msg, twist_to_msg, vector

if TYPE_CHECKING:
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.loop.received import ReceivedCounts


NO_LINK = "link not found, did you forget to scope the link by model name?"


def clearing(jobs: JobQueue, clear: Callable[[Any], Any], response: type) -> Callable[[Any], Any]:
    """Handler that runs clear(request) as a job; an error is logged alone, as in gazebo_ros."""

    def work(request: Any) -> None:
        try:
            jobs.call(lambda: clear(request))
        except SimError as error:
            rospy.logerr("%s", error)

    return empty_service_handler(work, response)


def requested_steps(world: World, request: Any) -> tuple[int, float]:
    """The range of physics steps of a request with start_time and duration."""
    return step_range(
        world.step_count, world.time_step, request.start_time.to_sec(), request.duration.to_sec()
    )


class LinkServices:
    """Services that read, move, change and push links."""

    def __init__(self, prefix: str, world: World, jobs: JobQueue, received: ReceivedCounts) -> None:
        self._world, self._jobs = world, jobs
        for name, service, work in (
            ("get_link_state", srv.GetLinkState, self._get_state),
            ("set_link_state", srv.SetLinkState, lambda r: self._set_state(r.link_state)),
            ("get_link_properties", srv.GetLinkProperties, self._get_properties),
            ("set_link_properties", srv.SetLinkProperties, self._set_properties),
            ("apply_body_wrench", srv.ApplyBodyWrench, self._push),
        ):
            rospy.Service(f"{prefix}/{name}", service, service_handler(work, service))
        rospy.Service(
            f"{prefix}/clear_body_wrenches",
            srv.BodyRequest,
            clearing(
                jobs,
                lambda r: world.forces.clear_link(*find_link(world, r.body_name, "body")),
                srv.BodyRequestResponse,
            ),
        )
        received.subscribe(f"{prefix}/set_link_state", LinkState, topic_callback(self._set_state))

    def _get_state(self, request: Any) -> srv.GetLinkStateResponse:
        def work() -> tuple[Pose, Array, Array]:
            with refusing(f"GetLinkState: {NO_LINK}"):
                model, link = find_link(self._world, request.link_name)
            with refusing("GetLinkState: " + NO_FRAME.format("reference_frame", "link")):
                frame = find_frame(self._world, request.reference_frame)
            return frame.inward(*model.link_state(link))

        pose, linear, angular = self._jobs.read(work)
        return srv.GetLinkStateResponse(
            link_state=LinkState(
                link_name=request.link_name,
                pose=pose_to_msg(pose),
                twist=twist_to_msg(linear, angular),
                reference_frame=request.reference_frame,
            ),
            status_message="GetLinkState: got state",
        )

    def _set_state(self, state: LinkState) -> srv.SetLinkStateResponse:
        pose = pose_from_msg(state.pose)
        linear, angular = vector(state.twist.linear), vector(state.twist.angular)

        def work() -> None:
            with refusing("SetLinkState: link does not exist"):
                model, link = find_link(self._world, state.link_name)
            with refusing("SetLinkState: failed"):
                frame = find_frame(self._world, state.reference_frame).pose
            index, offset = model.link_in_body(link)
            if index >= 0:
                raise ModelError(
                    f"link '{state.link_name}' hangs on a joint and has no pose that can be set; "
                    f"set the model's by '{model.name}::{model.description.root}', its joints "
                    "with set_model_configuration"
                )
            target, angular_in_world = frame * pose, frame.matrix @ angular
            if not target.is_placeable():
                raise ModelError(
                    f"pose for link '{state.link_name}' is {pose.position}, "
                    f"{pose.orientation}; {PLACEABLE}"
                )
            root = target.normalized() * offset.inverse()
            arm = np.subtract(root.position, target.position)
            linear_of_root = frame.matrix @ linear + np.cross(angular_in_world, arm)
            model.set_state(root, linear_of_root, angular_in_world)

        self._jobs.call(work)
        return srv.SetLinkStateResponse(status_message="SetLinkState: success")

    def _get_properties(self, request: Any) -> srv.GetLinkPropertiesResponse:
        def work() -> tuple[float, Array, Array, bool]:
            with refusing(f"GetLinkProperties: {NO_LINK}"):
                found = find_link(self._world, request.link_name)
            return changes.link_properties(*found)

        mass, center, inertia, gravity = self._jobs.read(work)
        com = PoseMsg()
        com.position.x, com.position.y, com.position.z = (float(c) for c in center)
        com.orientation.w = 1.0
        return srv.GetLinkPropertiesResponse(
            com=com,
            gravity_mode=gravity,
            mass=mass,
            ixx=inertia[0, 0],
            ixy=inertia[0, 1],
            ixz=inertia[0, 2],
            iyy=inertia[1, 1],
            iyz=inertia[1, 2],
            izz=inertia[2, 2],
            status_message="GetLinkProperties: got properties",
        )

    def _set_properties(self, request: Any) -> srv.SetLinkPropertiesResponse:
        inertia = [
            [request.ixx, request.ixy, request.ixz],
            [request.ixy, request.iyy, request.iyz],
            [request.ixz, request.iyz, request.izz],
        ]

        def work() -> None:
            with refusing(f"SetLinkProperties: {NO_LINK}"):
                model, link = find_link(self._world, request.link_name)
            changes.set_link_properties(
                model,
                link,
                request.mass,
                vector(request.com.position),
                inertia,
                request.gravity_mode,
            )

        self._jobs.call(work)
        return srv.SetLinkPropertiesResponse(status_message="SetLinkProperties: properties set")

    def _push(self, request: Any) -> srv.ApplyBodyWrenchResponse:
        """Wrench of a request, rotated into world axes about the center of mass.

        As in gazebo_ros, the force acts at the body's center of mass; reference_point and, for
        an entity's frame, the offset between the two origins add their torque.
        """
        force, torque = vector(request.wrench.force), vector(request.wrench.torque)
        torque = torque + np.cross(vector(request.reference_point), force)

        def work() -> None:
            with refusing("ApplyBodyWrench: body does not exist"):
                model, link = find_link(self._world, request.body_name, "body")
            rotated, moment = force, torque
            if request.reference_frame not in WORLD_FRAMES:
                with refusing("ApplyBodyWrench: reference_frame not found"):
                    frame = find_frame(self._world, request.reference_frame).pose
                body = model.link_state(link)[0]
                rotated = frame.matrix @ force
                moment = frame.matrix @ torque + np.cross(
                    np.subtract(frame.position, body.position), rotated
                )
            steps = requested_steps(self._world, request)
            self._world.forces.apply_wrench(model, link, rotated, moment, steps)

        self._jobs.call(work)
        return srv.ApplyBodyWrenchResponse()  # without a text, as upstream


CHANGEABLE = ("damping", "loStop", "hiStop")


class JointServices:
    """Services that read, change and drive joints."""

    def __init__(self, prefix: str, world: World, jobs: JobQueue) -> None:
        self._world, self._jobs = world, jobs
        for name, service, work in (
            ("get_joint_properties", srv.GetJointProperties, self._get_properties),
            ("set_joint_properties", srv.SetJointProperties, self._set_properties),
            ("apply_joint_effort", srv.ApplyJointEffort, self._drive),
        ):
            rospy.Service(f"{prefix}/{name}", service, service_handler(work, service))
        rospy.Service(
            f"{prefix}/clear_joint_forces",
            srv.JointRequest,
            clearing(
                jobs,
                lambda r: world.forces.clear_joint(*find_joint(world, r.joint_name)),
                srv.JointRequestResponse,
            ),
        )

    def _get_properties(self, request: Any) -> srv.GetJointPropertiesResponse:
        """Position and rate; each joint is REVOLUTE and has no damping, as gazebo_ros answers."""

        def work() -> srv.GetJointPropertiesResponse:
            with refusing("GetJointProperties: joint not found"):
                model, joint = find_joint(self._world, request.joint_name)
            response = srv.GetJointPropertiesResponse(type=srv.GetJointPropertiesResponse.REVOLUTE)
            if joint in model.joints.names:
                index = model.joints.names.index(joint)
                positions, rates, _ = model.joints.arrays()
                response.position = [float(positions[index])]
                response.rate = [float(rates[index])]
            return response

        response = self._jobs.read(work)
        response.status_message = "GetJointProperties: got properties"
        return response

    def _set_properties(self, request: Any) -> srv.SetJointPropertiesResponse:
        config = request.ode_joint_config
        given = {
            name: list(getattr(config, name)) for name in config.__slots__ if getattr(config, name)
        }
        for name, values in given.items():
            if name not in CHANGEABLE:
                raise ModelError(
                    f"joint '{request.joint_name}': {name} belongs to the engine ODE; "
                    f"what can change here is {', '.join(CHANGEABLE)}"
                )
            if len(values) != 1:
                raise ModelError(
                    f"joint '{request.joint_name}': {name} has {len(values)} values, "
                    "must have 1, for its one axis"
                )

        def work() -> None:
            with refusing("SetJointProperties: joint not found"):
                model, joint = find_joint(self._world, request.joint_name)
            if "loStop" in given or "hiStop" in given:
                changes.set_joint_stops(
                    model, joint, *(given.get(name, (None,))[0] for name in ("loStop", "hiStop"))
                )
            if "damping" in given:
                changes.set_joint_damping(model, joint, given["damping"][0])

        self._jobs.call(work)
        return srv.SetJointPropertiesResponse(status_message="SetJointProperties: properties set")

    def _drive(self, request: Any) -> srv.ApplyJointEffortResponse:
        def work() -> float:
            with refusing("ApplyJointEffort: joint not found"):
                model, joint = find_joint(self._world, request.joint_name)
            steps = requested_steps(self._world, request)
            return self._world.forces.apply_effort(model, joint, request.effort, steps)

        effort = self._jobs.call(work)
        if effort != request.effort:
            rospy.logwarn(
                "apply_joint_effort: the effort on '%s' is clipped from %g to %g, the limit of its "
                "description",
                request.joint_name,
                request.effort,
                effort,
            )
        return srv.ApplyJointEffortResponse(status_message="ApplyJointEffort: effort set")
