"""Services about joints: properties and efforts."""

import rospy
from bullet_sim.errors import ModelError, SimError
from bullet_sim.models import changes
from bullet_sim.models.changes import step_range
from gazebo_msgs.srv import (
    ApplyJointEffort,
    ApplyJointEffortResponse,
    GetJointProperties,
    GetJointPropertiesResponse,
    JointRequest,
    JointRequestResponse,
    SetJointProperties,
    SetJointPropertiesResponse,
)

from bullet_bridge.services.entities import find_joint
from bullet_bridge.services.handlers import empty_service_handler, service_handler

TYPES = {
    "revolute": GetJointPropertiesResponse.REVOLUTE,
    "continuous": GetJointPropertiesResponse.CONTINUOUS,
    "prismatic": GetJointPropertiesResponse.PRISMATIC,
    "fixed": GetJointPropertiesResponse.FIXED,
}
CHANGEABLE = ("damping", "loStop", "hiStop")


class JointServices:
    """Reading, changing and driving joints.

    Args:
        prefix: of the service names.
        world: of the core.
        jobs: JobQueue of the simulation thread.
    """

    def __init__(self, prefix, world, jobs):
        self._world, self._jobs = world, jobs
        for name, kind, work in (
            ("get_joint_properties", GetJointProperties, self._get_properties),
            ("set_joint_properties", SetJointProperties, self._set_properties),
            ("apply_joint_effort", ApplyJointEffort, self._drive),
        ):
            rospy.Service(f"{prefix}/{name}", kind, service_handler(work, kind))
        rospy.Service(
            f"{prefix}/clear_joint_forces",
            JointRequest,
            empty_service_handler(self._clear, JointRequestResponse),
        )

    def _get_properties(self, request):
        def work():
            model, joint = find_joint(self._world, request.joint_name)
            response = GetJointPropertiesResponse(type=TYPES[model.description.joints[joint].kind])
            if joint in model.joints.names:
                number = model.joints.names.index(joint)
                positions, rates, _ = model.joints.read()
                response.damping = [model.joints.limits[joint].damping]
                response.position = [float(positions[number])]
                response.rate = [float(rates[number])]
            return response

        response = self._jobs.call(work)
        response.status_message = "got the properties"
        return response

    def _set_properties(self, request):
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

        def work():
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

    def _drive(self, request):
        def work():
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

    def _clear(self, request):
        try:
            self._jobs.call(
                lambda: self._world.forces.clear_joint(*find_joint(self._world, request.joint_name))
            )
        except SimError as error:  # the response is empty and gazebo_ros always answers
            rospy.logerr("%s", error)
