"""Forces and contacts, applied and measured: their specifications, read from plugins."""

from dataclasses import dataclass

from bullet_sim.plugins.xml import plugin_label
from bullet_sim.xml_reader import child_number, child_text


@dataclass(frozen=True)
class ContactSpec:
    """A bumper: contacts of some collision shapes.

    Attributes:
        link: link that carries it.
        collisions: names of the shapes it watches, as collision names of the description.
        rate: messages per simulated second [Hz]; 0: one a physics step.
    """

    name: str
    link: str
    collisions: tuple[str, ...] = ()
    rate: float = 0.0
    topic: str = "/bumper_states"
    frame_id: str = "world"


@dataclass(frozen=True)
class ForceTorqueSpec:
    """libgazebo_ros_ft_sensor: the wrench of a joint's child link on its parent.

    Attributes:
        link: the child link, whose frame it is given in.
        joint: its name.
        rate: messages per simulated second [Hz]; 0: one a physics step.
        noise_stddev: on each number [N, N m].
    """

    name: str
    link: str
    joint: str
    rate: float = 0.0
    topic: str = "/wrench"
    frame_id: str = ""
    noise_stddev: float = 0.0


@dataclass(frozen=True)
class LinkForceSpec:
    """libgazebo_ros_f3d: the net force and torque on a link, along the world's axes."""

    name: str
    link: str
    rate: float = 0.0
    topic: str = "/force"
    frame_id: str = "world"


@dataclass(frozen=True)
class HandOfGodSpec:
    """libgazebo_ros_hand_of_god: pulls a link to the frame FRAME_desired.

    Attributes:
        frame: FRAME; where the link is comes as FRAME_actual.
        linear, angular: stiffness [N/m], [N m/rad]; it is critically damped.
    """

    name: str
    link: str
    frame: str = "hog"
    linear: float = 200.0
    angular: float = 200.0
    rate: float = 0.0
    topic: str = "/tf"


@dataclass(frozen=True)
class JointPosesSpec:
    """libgazebo_ros_joint_pose_trajectory: puts joints to the points of a trajectory in time."""

    name: str
    link: str
    rate: float = 0.0
    topic: str = "/set_joint_trajectory"


def _named(element, tag, known, model, kind):
    """What a tag names, or None with a warning."""
    name = child_text(element, tag, "")
    if name in known:
        return name
    model.warn(
        f"{plugin_label(element)} has {tag} '{name}', which is no {kind}; {kind}s are "
        f"{', '.join(known) or '(none)'}; it is left out"
    )
    return None


def ft_sensor(element, model, names):
    """libgazebo_ros_ft_sensor.so."""
    joint = _named(element, "jointName", model.joints, model, "joint")
    if joint is None:
        return
    child = model.joints[joint].child
    model.measured.add(joint)
    model.sensors.append(
        ForceTorqueSpec(
            name=element.get("name") or joint,
            link=child,
            joint=joint,
            rate=max(0.0, child_number(element, "updateRate", plugin_label(element), 0.0)),
            topic=names.text_topic("topicName", f"{joint}_wrench"),
            frame_id=child,
            noise_stddev=abs(child_number(element, "gaussianNoise", plugin_label(element), 0.0)),
        )
    )


def f3d(element, model, names):
    """libgazebo_ros_f3d.so."""
    link = _named(element, "bodyName", model.links, model, "link")
    if link is not None:
        model.sensors.append(
            LinkForceSpec(
                name=element.get("name") or link,
                link=link,
                topic=names.text_topic("topicName", f"{link}_force"),
                frame_id=names.frame(child_text(element, "frameName", "world"), prefixed=False),
            )
        )


def hand_of_god(element, model, _):
    """libgazebo_ros_hand_of_god.so; the link has no weight."""
    link = _named(element, "linkName", model.links, model, "link")
    if link is None:
        return
    model.links[link].gravity = False
    what = plugin_label(element)
    model.sensors.append(
        HandOfGodSpec(
            name=element.get("name") or "hand_of_god",
            link=link,
            frame=child_text(element, "frameId", "hog"),
            linear=abs(child_number(element, "kl", what, 200.0)),
            angular=abs(child_number(element, "ka", what, 200.0)),
        )
    )


def joint_pose_trajectory(element, model, names):
    """libgazebo_ros_joint_pose_trajectory.so."""
    model.sensors.append(
        JointPosesSpec(
            name=element.get("name") or "joint_pose_trajectory",
            link=model.root,
            topic=names.text_topic("topicName", "set_joint_trajectory"),
        )
    )
