"""Bumpers' messages: gazebo_msgs/ContactsState."""

from __future__ import annotations

from typing import Any

from bullet_sim.parts.outputs import ContactsOutput
from gazebo_msgs.msg import ContactsState

from bullet_bridge.transport.packed import PackedContacts
from bullet_bridge.transport.senders import sends


@sends(ContactsOutput)
def _contacts(part: Any, output: ContactsOutput) -> PackedContacts:
    return PackedContacts(part.publisher(output.topic, ContactsState), output.frame_id)
