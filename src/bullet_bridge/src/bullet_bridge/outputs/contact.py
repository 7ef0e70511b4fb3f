"""Bumpers: gazebo_msgs/ContactsState as libgazebo_ros_bumper.so publishes it."""

import numpy as np
from bullet_sim.pose import Pose
from bullet_sim.sensors.contact import nearest, watched_links
from gazebo_msgs.msg import ContactsState, ContactState
from geometry_msgs.msg import Vector3, Wrench

from bullet_bridge.outputs.sensors import Output
from bullet_bridge.transport.conversions import stamp


class ContactOutput(Output):
    """Contacts of the watched shapes, one state per pair of shapes; without contacts an empty list.

    As in Gazebo: positions and normals in the world, wrenches in the axes of the sensor's link,
    about its centre of mass; the sensor's shape comes first.
    """

    message = ContactsState

    def __init__(self, world, model, spec, seed):
        self._watched = watched_links(spec, model.description)
        self._indices = sorted({model.link_in_body(link)[0] for link, _ in self._watched})
        super().__init__(world, model, spec, seed)

    def update(self, time):
        message = ContactsState()
        message.header.stamp, message.header.frame_id = stamp(time), self.spec.frame_id
        pairs = {}
        for index in self._indices:
            for contact in self.world.engine.contacts(self.model.body, index):
                mine = self._named(self.model, index, contact.position)
                if not self._is_watched(mine[1]):
                    continue
                other = self._other(contact)
                pairs.setdefault((mine[0], other), (index, []))[1].append(contact)
        for (mine, other), (index, contacts) in pairs.items():
            message.states.append(self._state(mine, other, index, contacts))
        self.publisher.publish(message)

    def _is_watched(self, shape):
        return shape is not None and (
            (shape.link, shape.name) in self._watched or (shape.link, "") in self._watched
        )

    @staticmethod
    def _named(model, index, position):
        """(model::link::collision, its Shape) of the shape that a point in the world is on."""
        pose = Pose(*model.frame_at(index))
        name, shapes = model.collisions_at(index)
        shape = nearest(shapes, pose.matrix.T @ (position - np.asarray(pose.position)))
        if shape is None:
            return f"{model.name}::{name}::collision", None
        return f"{model.name}::{shape.link or name}::{shape.name or 'collision'}", shape

    def _other(self, contact):
        for model in self.world.models.values():
            if model.body == contact.body:
                return self._named(model, contact.link, contact.position)[0]
        return "world"

    def _state(self, mine, other, index, contacts):
        engine, body = self.world.engine, self.model.body
        rotation = Pose(*self.model.frame_at(index)).matrix.T
        centre = engine.link_centre(body, index)
        state = ContactState(
            collision1_name=mine,
            collision2_name=other,
            info=f"{len(contacts)} contact points of {mine} and {other}",
        )
        total = np.zeros(6)
        for contact in contacts:
            torque = np.cross(contact.position - centre, contact.force)
            wrench = np.concatenate([rotation @ contact.force, rotation @ torque])
            total += wrench
            state.wrenches.append(_wrench(wrench))
            state.contact_positions.append(Vector3(*contact.position.tolist()))
            state.contact_normals.append(Vector3(*contact.normal.tolist()))
            state.depths.append(contact.depth)
        state.total_wrench = _wrench(total)
        return state


def _wrench(values):
    return Wrench(force=Vector3(*values[:3].tolist()), torque=Vector3(*values[3:].tolist()))
