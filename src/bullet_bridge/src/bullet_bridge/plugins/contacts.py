"""Bumpers' messages: gazebo_msgs/ContactsState."""

from __future__ import annotations

from typing import Any

from bullet_sim.parts.outputs import ContactsOutput
from bullet_sim.plugins.contacts import ContactPair
from gazebo_msgs.msg import ContactsState, ContactState
from geometry_msgs.msg import Vector3, Wrench

from bullet_bridge.transport import conversions
from bullet_bridge.transport.senders import Converted, sends


@sends(ContactsOutput)
def _contacts(part: Any, output: ContactsOutput) -> Converted:
    def convert(time: float, states: Any) -> ContactsState:
        message = ContactsState(header=conversions.header(time, output.frame_id))
        message.states = list(map(_contact_state, states))
        for number, state in enumerate(message.states):
            state.info = f"Debug:  i:({number}/{len(states)})     {state.info}"
        return message

    return Converted(part.publisher(output.topic, ContactsState), convert)


def _contact_state(pair: ContactPair) -> ContactState:
    """gazebo_msgs/ContactState of the contacts of a pair of shapes in a step."""
    stamp = conversions.stamp(pair.time)
    return ContactState(
        info=(  # upstream's text
            f"my geom:{pair.first}   other geom:{pair.second}         "
            f"time:{stamp.secs}.{stamp.nsecs:09d}\n"
        ),
        collision1_name=pair.first,
        collision2_name=pair.second,
        wrenches=[_wrench(wrench) for wrench in pair.wrenches],
        total_wrench=_wrench(pair.total),
        contact_positions=[Vector3(*position.tolist()) for position in pair.positions],
        contact_normals=[Vector3(*normal.tolist()) for normal in pair.normals],
        depths=list(pair.depths),
    )


def _wrench(values: Any) -> Wrench:
    return Wrench(force=Vector3(*values[:3].tolist()), torque=Vector3(*values[3:].tolist()))
