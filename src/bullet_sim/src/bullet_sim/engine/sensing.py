"""What sensors ask: rays and contacts."""

import operator

import numpy as np

from bullet_sim.engine.library import p
from bullet_sim.engine.sweep import Sweep
from bullet_sim.sensors.contact import Contact

_BODY, _FRACTION = operator.itemgetter(0), operator.itemgetter(2)  # of a ray's hit


class Sensing(Sweep):
    """Questions to the collision shapes."""

    def ray_batch(self, origins, targets, mask=-1):
        """Cast rays between points (N, 3) of the world frame at what has a group of the mask.

        Returns:
            fractions (N,) of the way to the first hit, 1.0 for a miss; bodies (N,), -1: miss.
        """
        hits, limit = [], p.MAX_RAY_INTERSECTION_BATCH_SIZE
        origins, targets = np.asarray(origins), np.asarray(targets)
        for start in range(0, len(origins), limit):
            hits += p.rayTestBatch(
                origins[start : start + limit],
                targets[start : start + limit],
                collisionFilterMask=mask,
                physicsClientId=self._client,
            )
        return (
            np.fromiter(map(_FRACTION, hits), float, len(hits)),
            np.fromiter(map(_BODY, hits), int, len(hits)),
        )

    def contacts(self, body, link):
        """Contact points of one link as of the last step.

        Returns:
            List of sensors.contact.Contact that press or touch, in the engine's order.
        """
        found = []
        for point in p.getContactPoints(bodyA=body, linkIndexA=link, physicsClientId=self._client):
            if point[8] > 0.0 and point[9] <= 0.0:  # near, but without contact
                continue
            normal = np.array(point[7])
            force = (
                point[9] * normal
                + point[10] * np.array(point[11])
                + point[12] * np.array(point[13])
            )
            found.append(Contact(point[2], point[4], np.array(point[5]), normal, -point[8], force))
        return found

    def all_contacts(self):
        """Contact points of all bodies that press, as of the last step.

        Returns:
            (n, 3) places [m], (n, 3) unit normals, (n,) normal forces [N], in the world frame.
        """
        points = [
            (point[5], point[7], point[9])
            for point in p.getContactPoints(physicsClientId=self._client)
            if point[9] > 0.0
        ]
        places, normals, forces = zip(*points) if points else ((), (), ())
        return np.reshape(places, (-1, 3)), np.reshape(normals, (-1, 3)), np.array(forces, float)

    def contact_count(self, body, link):
        """Number of contact points of one link."""
        return len(p.getContactPoints(bodyA=body, linkIndexA=link, physicsClientId=self._client))
