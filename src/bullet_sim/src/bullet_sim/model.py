"""One model in the world: its body, links, joints, controllers and sensors."""

import os

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.joints import Joints
from bullet_sim.lump import lump
from bullet_sim.manager import Manager
from bullet_sim.pose import Pose
from bullet_sim.prepare import prepared_urdf
from bullet_sim.snapshot import BodySource, BodyState


class Model:
    """A loaded ModelDescription.

    Args:
        engine: the Engine.
        key: identity in snapshots.
        description: ModelDescription.
        pose: world Pose of the root link's frame.
        folder: where the prepared URDF is written.

    Raises:
        ModelError: PyBullet refuses it.
    """

    def __init__(self, engine, key, description, pose, folder):
        self.name = description.name
        self.description = description
        self.initial_pose = pose
        self._engine = engine
        self._key = key
        self._lumped = lump(description)
        path = os.path.join(folder, f'{key}.urdf')
        with open(path, 'w', encoding='utf-8') as file:
            file.write(prepared_urdf(self._lumped, description.static))
        self.source = BodySource(key, path, description.static)
        self._load()
        self.joints = Joints(engine, self.body, self._lumped.joints)
        self.manager = None if description.control_namespace is None else Manager(self.joints)

    def _load(self):
        self.body = self._engine.load(self.source.path, self.initial_pose.position,
                                      self.initial_pose.orientation, self.is_static)
        self._links = self._engine.link_indices(self.body)
        for name, link in self._lumped.links.items():
            self._engine.set_surface(self.body, self._links[name],
                                     friction=link.surface.friction,
                                     stiffness=link.surface.stiffness,
                                     damping=link.surface.damping)

    def reload(self):
        """Load again into a cleared engine, at the initial pose; controllers restart."""
        self._load()
        self.joints.rebind(self.body)
        if self.manager is not None:
            self.manager.restart()

    @property
    def is_static(self):
        """Whether it never moves."""
        return self.description.static

    @property
    def link_names(self):
        """Names of all links of the original description."""
        return tuple(self.description.links)

    def carrier(self, link):
        """Where a link lives: (index of the body's link in the engine, Pose in it).

        Raises:
            ModelError: no such link.
        """
        if link not in self._lumped.frames:
            raise ModelError(f"model '{self.name}' has no link '{link}'; links are "
                             f"{', '.join(self.link_names)}")
        name, pose = self._lumped.frames[link]
        return self._links[name], pose

    def link_state(self, link):
        """Pose of a link's frame and its origin's velocity in the world.

        Returns:
            Pose, linear (3,) [m/s], angular (3,) [rad/s]; velocities along world axes.
        """
        index, offset = self.carrier(link)
        position, orientation, linear, angular = self._engine.link_state(self.body, index)
        frame = Pose(tuple(position.tolist()), tuple(orientation.tolist()))
        arm = frame.matrix @ np.asarray(offset.position)
        return frame * offset, linear + np.cross(angular, arm), angular

    @property
    def pose(self):
        """World pose of the root link's frame."""
        position, orientation = self._engine.base_pose(self.body)
        return Pose(tuple(position), tuple(orientation))

    def set_state(self, pose, linear=(0, 0, 0), angular=(0, 0, 0)):
        """Put the root link's frame at a world pose with a velocity (world axes).

        Raises:
            ModelError: a number is NaN or infinite, or the quaternion is zero.
        """
        if not pose.is_finite():
            raise ModelError(f"pose for model '{self.name}' is {pose.position}, "
                             f'{pose.orientation}; must be finite with a quaternion of length 1')
        pose = pose.normalised()
        self._engine.set_base_pose(self.body, pose.position, pose.orientation)
        if not self.is_static:
            self._engine.set_base_velocity(self.body, linear, angular)

    def state(self):
        """BodyState for a snapshot."""
        position, orientation = self._engine.base_pose(self.body)
        joints = () if self.is_static else tuple(self._engine.read_joints(self.body)[0].tolist())
        return BodyState(self._key, tuple(position), tuple(orientation), joints)

    def remove(self):
        """Take it out of the engine and delete its file."""
        self._engine.remove(self.body)
        if os.path.exists(self.source.path):
            os.remove(self.source.path)
