"""Services about links and joints: state, properties, wrenches and efforts."""

from typing import TYPE_CHECKING, Any

import numpy as np
import rospy
from bullet_sim.errors import ModelError, SimError
from bullet_sim.models import changes
from bullet_sim.models.changes import step_range
from bullet_sim.pose import PLACEABLE, Array, Pose
from gazebo_msgs.msg import LinkState
from gazebo_msgs.srv import (
    ApplyBodyWrench,
    ApplyBodyWrenchResponse,
    ApplyJointEffort,
    ApplyJointEffortResponse,
    BodyRequest,
    BodyRequestResponse,
    GetJointProperties,
    GetJointPropertiesResponse,
    GetLinkProperties,
    GetLinkPropertiesResponse,
    GetLinkState,
    GetLinkStateResponse,
    JointRequest,
    JointRequestResponse,
    SetJointProperties,
    SetJointPropertiesResponse,
    SetLinkProperties,
    SetLinkPropertiesResponse,
    SetLinkState,
    SetLinkStateResponse,
)
from geometry_msgs.msg import Pose as PoseMsg

from bullet_bridge.services.entities import WORLD_FRAMES, find_frame, find_joint, find_link
from bullet_bridge.services.handlers import empty_service_handler, service_handler, topic_callback
from bullet_bridge.transport.conversions import pose_from_msg, pose_to_msg, twist_to_msg, vector

if TYPE_CHECKING:
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.loop.received import ReceivedCounts


class LinkServices:
    """Services that read, move, change and push links.

    Args:
        prefix: of the service names.
        received: ReceivedCounts of the messages.
    """

    def __init__(
        self, prefix: str, world: "World", jobs: "JobQueue", received: "ReceivedCounts"
    ) -> None:
        self._world, self._jobs = world, jobs
        for name, service, work in (
            ("get_link_state", GetLinkState, self._get_state),
            ("set_link_state", SetLinkState, lambda request: self._set_state(request.link_state)),
            ("get_link_properties", GetLinkProperties, self._get_properties),
            ("set_link_properties", SetLinkProperties, self._set_properties),
            ("apply_body_wrench", ApplyBodyWrench, self._push),
        ):
            rospy.Service(f"{prefix}/{name}", service, service_handler(work, service))
        rospy.Service(
            f"{prefix}/clear_body_wrenches",
            BodyRequest,
            empty_service_handler(self._clear, BodyRequestResponse),
        )
        received.subscribe(f"{prefix}/set_link_state", LinkState, topic_callback(self._set_state))

    def _get_state(self, request: Any) -> GetLinkStateResponse:
        def work() -> tuple[Pose, Array, Array]:
            model, link = find_link(self._world, request.link_name)
            frame = find_frame(self._world, request.reference_frame)
            return frame.inward(*model.link_state(link))

        pose, linear, angular = self._jobs.call(work)
        return GetLinkStateResponse(
            link_state=LinkState(
                link_name=request.link_name,
                pose=pose_to_msg(pose),
                twist=twist_to_msg(linear, angular),
                reference_frame=request.reference_frame,
            ),
            status_message="got the state",
        )

    def _set_state(self, state: LinkState) -> SetLinkStateResponse:
        pose = pose_from_msg(state.pose)
        linear, angular = vector(state.twist.linear), vector(state.twist.angular)

        def work() -> None:
            model, link = find_link(self._world, state.link_name)
            index, offset = model.link_in_body(link)
            if index >= 0:
                raise ModelError(
                    f"link '{state.link_name}' hangs on a joint and has no pose that can be set; "
                    f"set the model's by '{model.name}::{model.description.root}', its joints "
                    "with set_model_configuration"
                )
            frame = find_frame(self._world, state.reference_frame).pose
            target, angular_in_world = frame * pose, frame.matrix @ angular
            if not target.is_placeable():
                raise ModelError(
                    f"pose for link '{state.link_name}' is {pose.position}, "
                    f"{pose.orientation}; {PLACEABLE}"
                )
            root = target.normalised() * offset.inverse()
            arm = np.subtract(root.position, target.position)
            linear_of_root = frame.matrix @ linear + np.cross(angular_in_world, arm)
            model.set_state(root, linear_of_root, angular_in_world)

        self._jobs.call(work)
        return SetLinkStateResponse(status_message=f"moved '{state.link_name}'")

    def _get_properties(self, request: Any) -> GetLinkPropertiesResponse:
        def work() -> tuple[float, Array, Array]:
            return changes.link_properties(*find_link(self._world, request.link_name))

        mass, center, inertia = self._jobs.call(work)
        com = PoseMsg()
        com.position.x, com.position.y, com.position.z = (float(c) for c in center)
        com.orientation.w = 1.0
        return GetLinkPropertiesResponse(
            com=com,
            gravity_mode=True,
            mass=mass,
            ixx=inertia[0, 0],
            ixy=inertia[0, 1],
            ixz=inertia[0, 2],
            iyy=inertia[1, 1],
            iyz=inertia[1, 2],
            izz=inertia[2, 2],
            status_message="got the properties",
        )

    def _set_properties(self, request: Any) -> SetLinkPropertiesResponse:
        inertia = [
            [request.ixx, request.ixy, request.ixz],
            [request.ixy, request.iyy, request.iyz],
            [request.ixz, request.iyz, request.izz],
        ]

        def work() -> None:
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
        return SetLinkPropertiesResponse(status_message=f"changed '{request.link_name}'")

    def _push(self, request: Any) -> ApplyBodyWrenchResponse:
        """Wrench of a request, rotated into world axes about the center of mass.

        As in gazebo_ros, the force acts at the body's center of mass; reference_point and, for
        an entity's frame, the offset between the two origins add their torque.
        """
        force, torque = vector(request.wrench.force), vector(request.wrench.torque)
        torque = torque + np.cross(vector(request.reference_point), force)

        def work() -> None:
            model, link = find_link(self._world, request.body_name, "body")
            rotated, moment = force, torque
            if request.reference_frame not in WORLD_FRAMES:
                frame = find_frame(self._world, request.reference_frame).pose
                body = model.link_state(link)[0]
                rotated = frame.matrix @ force
                moment = frame.matrix @ torque + np.cross(
                    np.subtract(frame.position, body.position), rotated
                )
            self._world.forces.apply_wrench(
                model,
                link,
                rotated,
                moment,
                step_range(
                    self._world.step_count,
                    self._world.time_step,
                    request.start_time.to_sec(),
                    request.duration.to_sec(),
                ),
            )

        self._jobs.call(work)
        return ApplyBodyWrenchResponse(status_message=f"wrench on '{request.body_name}' is set")

    def _clear(self, request: Any) -> None:
        try:
            self._jobs.call(
                lambda: self._world.forces.clear_link(
                    *find_link(self._world, request.body_name, "body")
                )
            )
        except SimError as error:  # the response is empty and gazebo_ros always responds
            rospy.logerr("%s", error)


TYPES = {
    "revolute": GetJointPropertiesResponse.REVOLUTE,
    "continuous": GetJointPropertiesResponse.CONTINUOUS,
    "prismatic": GetJointPropertiesResponse.PRISMATIC,
    "fixed": GetJointPropertiesResponse.FIXED,
}
CHANGEABLE = ("damping", "loStop", "hiStop")


class JointServices:
    """Services that read, change and drive joints.

    Args:
        prefix: of the service names.
    """

    def __init__(self, prefix: str, world: "World", jobs: "JobQueue") -> None:
        self._world, self._jobs = world, jobs
        for name, service, work in (
            ("get_joint_properties", GetJointProperties, self._get_properties),
            ("set_joint_properties", SetJointProperties, self._set_properties),
            ("apply_joint_effort", ApplyJointEffort, self._drive),
        ):
            rospy.Service(f"{prefix}/{name}", service, service_handler(work, service))
        rospy.Service(
            f"{prefix}/clear_joint_forces",
            JointRequest,
            empty_service_handler(self._clear, JointRequestResponse),
        )

    def _get_properties(self, request: Any) -> GetJointPropertiesResponse:
        def work() -> GetJointPropertiesResponse:
            model, joint = find_joint(self._world, request.joint_name)
            response = GetJointPropertiesResponse(type=TYPES[model.description.joints[joint].kind])
            if joint in model.joints.names:
                index = model.joints.names.index(joint)
                positions, rates, _ = model.joints.arrays()
                response.damping = [model.joints.limits[joint].damping]
                response.position = [float(positions[index])]
                response.rate = [float(rates[index])]
            return response

        response = self._jobs.call(work)
        response.status_message = "got the properties"
        return response

    def _set_properties(self, request: Any) -> SetJointPropertiesResponse:
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
        if not given:
            raise ModelError(
                f"joint '{request.joint_name}': nothing to change; give one of "
                f"{', '.join(CHANGEABLE)}"
            )

        def work() -> None:
            model, joint = find_joint(self._world, request.joint_name)
            if "loStop" in given or "hiStop" in given:
                changes.set_joint_stops(
                    model, joint, *(given.get(name, (None,))[0] for name in ("loStop", "hiStop"))
                )
            if "damping" in given:
                changes.set_joint_damping(model, joint, given["damping"][0])

        self._jobs.call(work)
        return SetJointPropertiesResponse(
            status_message=f"changed {', '.join(given)} of '{request.joint_name}'"
        )

    def _drive(self, request: Any) -> ApplyJointEffortResponse:
        def work() -> float:
            model, joint = find_joint(self._world, request.joint_name)
            return self._world.forces.apply_effort(
                model,
                joint,
                request.effort,
                step_range(
                    self._world.step_count,
                    self._world.time_step,
                    request.start_time.to_sec(),
                    request.duration.to_sec(),
                ),
            )

        effort = self._jobs.call(work)
        text = f"effort on '{request.joint_name}' is set"
        if effort != request.effort:
            text += f", clipped to {effort:g}, the limit of its description"
        return ApplyJointEffortResponse(status_message=text)

    def _clear(self, request: Any) -> None:
        try:
            self._jobs.call(
                lambda: self._world.forces.clear_joint(*find_joint(self._world, request.joint_name))
            )
        except SimError as error:  # the response is empty and gazebo_ros always responds
            rospy.logerr("%s", error)
