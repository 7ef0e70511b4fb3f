"""What bodies touch: pairs, overlaps, friction and sliding; masks of what may touch."""

import math

from bullet_sim.engine.client import velocity_at
from bullet_sim.engine.library import p
from bullet_sim.engine.saving import Saving

_SATURATED = 0.98  # of the friction limit: from here on a contact counts as sliding
_MAX_FRICTION = 10.0  # to which Bullet cuts the coefficient of a pair
# Bits that a link with a collide_bitmask of its own shares with all that have none, and where its
# own bits begin.
_COMMON, _SHIFT = 3, 8
_STATIC, _GHOST = 2, 64  # Bullet's group of what never moves, our own of ghosts


class Touch(Saving):
    """Contacts between bodies."""

    def set_friction(self, body, link, friction, scale=None):
        """Set the Coulomb coefficient of a link; that of a pair is the product of both.

        Args:
            body, link: as link_indices gives it.
            friction: coefficient along the direction of greatest friction.
            scale: (3,) factors from 0 to 1 along the link's principal axes; None: isotropic.
        """
        values = {"lateralFriction": friction}
        if scale is not None or (body, link) in self._scaled:
            values["anisotropicFriction"] = tuple(scale or (1.0, 1.0, 1.0))
            self._scaled.add((body, link))
        self._friction[body, link] = friction
        p.changeDynamics(body, link, physicsClientId=self._client, **values)

    def friction(self, body, link):
        """The coefficient that set_friction has set."""
        return self._friction[body, link]

    def set_bitmask(self, body, link, bits):
        """Let a link touch only what shares a bit (of 16) with it; the others have all bits."""
        self._scenery.discard(body)  # rays may go through it
        own = bits << _SHIFT
        p.setCollisionFilterGroupMask(
            body, link, own, own | (_COMMON if bits else 0), physicsClientId=self._client
        )
        self._note_layout("mask", body, link)

    def set_ghost(self, body, link):
        """Let a link touch only what never moves; rays go through it."""
        self._scenery.discard(body)
        p.setCollisionFilterGroupMask(body, link, _GHOST, _STATIC, physicsClientId=self._client)
        self._note_layout("mask", body, link)

    def set_pair_collision(self, body, link, other, other_link, collide):
        """Enable or disable collision between two links of different bodies."""
        p.setCollisionFilterPair(
            body, other, link, other_link, int(collide), physicsClientId=self._client
        )
        self._note_layout("pair", body, other)

    def touching(self, body):
        """Pairs in contact as of the last step.

        Returns:
            List of (link, other body, other link, normal force [N]).
        """
        return [
            (point[3], point[2], point[4], point[9])
            for point in p.getContactPoints(bodyA=body, physicsClientId=self._client)
            if point[9] > 0.0
        ]

    def overlaps(self, body, depth):
        """Contacts of a body in which it reaches deeper than `depth` [m] into another, now.

        Returns:
            List of (link, other body, other link, depth [m], normal (3,) towards the body).
        """
        p.performCollisionDetection(physicsClientId=self._client)
        return [
            (point[3], point[2], point[4], -point[8], point[7])
            for point in p.getContactPoints(bodyA=body, physicsClientId=self._client)
            if point[2] != body and point[8] < -depth
        ]

    def pair_depth(self, body, link, other, other_link):
        """How deep [m] two links overlap, also where they pass through each other; 0: not."""
        points = p.getClosestPoints(
            body, other, 0.0, link, other_link, physicsClientId=self._client
        )
        return max((-point[8] for point in points), default=0.0)

    def slip(self, body, links, slowest):
        """Sliding contacts of a body's links, as of the last step.

        Args:
            body: the body.
            links: those that are looked at.
            slowest: [m/s] below which nothing counts as sliding.

        Returns:
            List of (link, point (3,) [m], friction force (3,) [N] on the link, velocity (3,) [m/s]
            of the link's material against the other body's, limit [N]); world axes.
        """
        found = []
        for point in p.getContactPoints(bodyA=body, physicsClientId=self._client):
            link, normal_force = point[3], point[9]
            if normal_force <= 0.0 or link not in links:
                continue
            other = point[2], point[4]
            product = self._friction[body, link] * self._friction.get(other, 1.0)
            limit = min(product, _MAX_FRICTION) * normal_force
            a, b, one, two = point[10], point[12], point[11], point[13]
            force = (a * one[0] + b * two[0], a * one[1] + b * two[1], a * one[2] + b * two[2])
            if math.hypot(*force) < _SATURATED * limit:
                continue
            mine = self._point_velocity(body, link, point[5])
            its = self._point_velocity(*other, point[6]) if self._moves(other[0]) else (0, 0, 0)
            n = point[7]
            velocity = [u - v for u, v in zip(mine, its)]
            along = sum(u * v for u, v in zip(velocity, n))
            velocity = tuple(u - along * v for u, v in zip(velocity, n))
            if math.hypot(*velocity) > slowest:
                found.append((link, point[5], force, velocity, limit))
        return found

    def is_free(self, body):
        """Whether a body's root link is not fixed to the world."""
        return body in self._free

    def _moves(self, body):
        return bool(self._movable.get(body)) or body in self._free

    def _point_velocity(self, body, link, point):
        """Velocity (3,) of the material of a link at a world point."""
        centre, linear, angular, _ = self.link_velocity(body, link)
        return velocity_at(point, centre, linear, angular)

    def apply_force(self, body, link, force, point):
        """Apply a force (3,) [N] to a link at a world point for the next step only."""
        p.applyExternalForce(body, link, force, point, p.WORLD_FRAME, physicsClientId=self._client)
