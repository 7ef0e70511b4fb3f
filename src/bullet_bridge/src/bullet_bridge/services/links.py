"""Services about links and joints: state, properties, wrenches and efforts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import rospy
from bullet_sim.models import changes
from bullet_sim.models.changes import step_range
from bullet_sim.pose import Array, Pose
from gazebo_msgs import srv
from gazebo_msgs.msg import LinkState
from geometry_msgs.msg import Pose as PoseMsg

from bullet_bridge.services.entities import (
    WORLD_FRAMES,
    Frame,
    find_frame,
    find_joint,
    find_link,
)
from bullet_bridge.services.handlers import (
    NO_FRAME,
    Refusal,
    empty_service_handler,
    offer,
    refusing,
    topic_callback,
)
from bullet_bridge.transport.conversions import pose_from_msg, pose_to_msg, twist_to_msg, vector

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.loop.received import ReceivedCounts


NO_LINK = "link not found, did you forget to scope the link by model name?"


def offer_clearing(name: str, kind: Any, jobs: JobQueue, clear: Callable[[Any], Any]) -> None:
    """Offer a service that runs clear(request) as a job; it succeeds, whatever it clears, as
    upstream."""

    def work(request: Any) -> None:
        jobs.call(lambda: clear(request))

    rospy.Service(name, kind, empty_service_handler(work, kind._response_class))


def requested_steps(world: World, request: Any) -> tuple[int, float]:
    """The range of physics steps of a request with start_time and duration."""
    return step_range(
        world.step_count, world.time_step, request.start_time.to_sec(), request.duration.to_sec()
    )


class LinkServices:
    """Services that read, move, change and push links."""

    def __init__(self, prefix: str, world: World, jobs: JobQueue, received: ReceivedCounts) -> None:
        self._world, self._jobs = world, jobs
        offer(
            prefix,
            ("get_link_state", srv.GetLinkState, self._get_state),
            ("set_link_state", srv.SetLinkState, lambda r: self._set_state(r.link_state)),
            ("get_link_properties", srv.GetLinkProperties, self._get_properties),
            ("set_link_properties", srv.SetLinkProperties, self._set_properties),
            ("apply_body_wrench", srv.ApplyBodyWrench, self._push),
        )
        name, forces = f"{prefix}/clear_body_wrenches", world.forces
        offer_clearing(name, srv.BodyRequest, jobs, lambda r: forces.clear_link(r.body_name))
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

    def _link_frame(self, name: str) -> Frame:
        """Frame of a link's name or of the world; that of a model is none here, as in gazebo_ros.

        Raises:
            WorldError: there is none.
        """
        if name in WORLD_FRAMES:
            return Frame()
        model, link = find_link(self._world, name, "reference frame")
        return Frame(*model.link_state(link))

    def _set_state(self, state: LinkState) -> srv.SetLinkStateResponse:
        """Place a link; its velocity is along the world's axes, less the frame's, as upstream."""
        pose = pose_from_msg(state.pose)
        linear, angular = vector(state.twist.linear), vector(state.twist.angular)

        def work() -> None:
            with refusing("SetLinkState: link does not exist"):
                model, link = find_link(self._world, state.link_name)
            with refusing("SetLinkState: failed"):
                frame = self._link_frame(state.reference_frame)
            target = frame.pose * pose
            model.set_link_state(link, target, linear - frame.linear, angular - frame.angular)

        self._jobs.call(work)
        return srv.SetLinkStateResponse(status_message="SetLinkState: success")

    def _get_properties(self, request: Any) -> srv.GetLinkPropertiesResponse:
        def work() -> tuple[float, Array, Array, bool]:
            with refusing(f"GetLinkProperties: {NO_LINK}"):
                model, link = find_link(self._world, request.link_name)
            properties = changes.gazebos_properties(model, link)
            if model.is_static:  # of which Gazebo has no mass
                properties = 0.0, properties[1], np.zeros((3, 3)), False
            return model.set_masses.get(link, properties[:3]) + properties[3:]

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
        """As Gazebo 11 does: gravity changes; mass and inertia are what get_link_properties tells
        from then on, and the link moves as before; another center of mass shifts its frame."""
        inertia = [
            [request.ixx, request.ixy, request.ixz],
            [request.ixy, request.iyy, request.iyz],
            [request.ixz, request.iyz, request.izz],
        ]

        def work() -> None:
            with refusing(f"SetLinkProperties: {NO_LINK}"):
                model, link = find_link(self._world, request.link_name)
            model.set_masses[link] = request.mass, vector(request.com.position), np.array(inertia)
            model.tell_center(link, vector(request.com.position))
            if not model.is_static:
                changes.set_link_gravity(model, link, request.gravity_mode)

        self._jobs.call(work)
        return srv.SetLinkPropertiesResponse(status_message="SetLinkProperties: properties set")

    def _push(self, request: Any) -> srv.ApplyBodyWrenchResponse:
        """Apply a wrench.

        As in gazebo_ros the force acts at the body's center of mass, and reference_point and, for
        an entity's frame, the offset between the two origins add their torque. That frame's wrench
        is turned into the body's axes and then acts along the world's.
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
                in_body = model.link_state(link)[0].inverse() * frame
                rotated = in_body.matrix @ force
                moment = in_body.matrix @ torque + np.cross(in_body.position, rotated)
            steps = requested_steps(self._world, request)
            self._world.forces.apply_wrench(model, link, rotated, moment, steps)
            model.times_moved += 1

        self._jobs.call(work)
        return srv.ApplyBodyWrenchResponse()  # without a text, as upstream


PARAMETERS = ("erp", "cfm", "stop_erp", "stop_cfm", "fudge_factor", "fmax", "vel")


def gazebos_joint(world: World, name: str, refusal: str) -> tuple[Model, str]:
    """As find_joint, of those that Gazebo has: sdformat merges the links of fixed joints.

    Raises:
        Refusal: there is none.
    """
    with refusing(refusal):
        model, name = find_joint(world, name)
    if not model.stays(name):
        raise Refusal(refusal, f"joint '{name}' is fixed, and its links are one")
    return model, name


def _set_axis(model: Model, axis: str, values: dict[str, float]) -> list[str]:
    """Change properties of one axis of a joint; returns the names of those without effect."""
    if "loStop" in values or "hiStop" in values:
        changes.set_joint_stops(model, axis, values.get("loStop"), values.get("hiStop"))
    if "damping" in values:
        changes.set_joint_damping(model, axis, values["damping"])
    return [
        name
        for name in PARAMETERS
        if name in values and not changes.set_joint_parameter(model, axis, name, values[name])
    ]


class JointServices:
    """Services that read, change and drive joints."""

    def __init__(self, prefix: str, world: World, jobs: JobQueue) -> None:
        self._world, self._jobs = world, jobs
        offer(
            prefix,
            ("get_joint_properties", srv.GetJointProperties, self._get_properties),
            ("set_joint_properties", srv.SetJointProperties, self._set_properties),
            ("apply_joint_effort", srv.ApplyJointEffort, self._drive),
        )
        name, forces = f"{prefix}/clear_joint_forces", world.forces
        offer_clearing(name, srv.JointRequest, jobs, lambda r: forces.clear_joint(r.joint_name))

    def _get_properties(self, request: Any) -> srv.GetJointPropertiesResponse:
        """Position and rate; each joint is REVOLUTE and has no damping, as gazebo_ros answers."""

        def work() -> srv.GetJointPropertiesResponse:
            refusal = "GetJointProperties: joint not found"
            model, joint = gazebos_joint(self._world, request.joint_name, refusal)
            response = srv.GetJointPropertiesResponse(type=srv.GetJointPropertiesResponse.REVOLUTE)
            response.position, response.rate = [0.0], [0.0]  # of a fixed one
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
        """Change what is given, of each axis a value, as gazebo_ros does."""
        config = request.ode_joint_config
        given = {
            name: list(getattr(config, name)) for name in config.__slots__ if getattr(config, name)
        }
        without_effect: list[str] = []

        def work() -> None:
            refusal = "SetJointProperties: joint not found"
            model, joint = gazebos_joint(self._world, request.joint_name, refusal)
            if joint not in model.joints.names:
                return  # a fixed one
            axes = model.axes_of(joint)
            for index, axis in enumerate(axes):
                of_axis = {name: v[index] for name, v in given.items() if index < len(v)}
                lacking = _set_axis(model, axis, of_axis)
                without_effect.extend(f"{name}[{index}]" if index else name for name in lacking)
            beyond = [name for name, values in given.items() if len(values) > len(axes)]
            without_effect.extend(f"{name}[{len(axes)}]" for name in beyond)

        self._jobs.call(work)
        if without_effect:
            rospy.logwarn(
                "set_joint_properties: %s of '%s' have no effect",
                ", ".join(without_effect),
                request.joint_name,
            )
        return srv.SetJointPropertiesResponse(status_message="SetJointProperties: properties set")

    def _drive(self, request: Any) -> srv.ApplyJointEffortResponse:
        def work() -> None:
            refusal = "ApplyJointEffort: joint not found"
            model, joint = gazebos_joint(self._world, request.joint_name, refusal)
            if joint in model.joints.names:  # a fixed one takes none
                steps = requested_steps(self._world, request)
                self._world.forces.apply_effort(model, joint, request.effort, steps)

        self._jobs.call(work)
        return srv.ApplyJointEffortResponse(status_message="ApplyJointEffort: effort set")
