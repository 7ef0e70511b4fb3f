"""A planar laser scanner by ray casting."""

import numpy as np

from bullet_sim.sensors.frames import matrix_from_quaternion, matrix_from_rpy

MAX_RAYS = 1_000_000  # of a scan; it costs some 100 bytes for each


class Lidar:
    """Ray directions of one RaySpec, computed once.

    Rays lie in the x-y plane of the sensor frame, counted counter-clockwise from min_angle to
    max_angle, both included (sensor_msgs/LaserScan).

    Attributes:
        spec: the RaySpec.
        angles: (n,) [rad].
        angle_increment: [rad], 0 for a single ray.
        directions: (n, 3) unit vectors in the sensor frame.

    Raises:
        ValueError: samples < 1, more than MAX_RAYS, angles or ranges in the wrong order, negative
            noise.
    """

    def __init__(self, spec):
        if int(spec.samples) != spec.samples or spec.samples < 1:
            raise ValueError(
                f"lidar {spec.name}: samples {spec.samples}, a whole number >= 1 is expected"
            )
        rays = spec.samples * getattr(spec, "layers", 1)
        if rays > MAX_RAYS:
            raise ValueError(f"lidar {spec.name}: {rays} rays, at most {MAX_RAYS} are expected")
        if not spec.max_angle >= spec.min_angle:
            raise ValueError(
                f"lidar {spec.name}: min_angle {spec.min_angle}, max_angle "
                f"{spec.max_angle}: min_angle <= max_angle rad is expected"
            )
        if not 0.0 <= spec.range_min < spec.range_max < np.inf:
            raise ValueError(
                f"lidar {spec.name}: range_min {spec.range_min}, range_max "
                f"{spec.range_max}: 0 <= range_min < range_max m is expected"
            )
        if not spec.noise_stddev >= 0.0:
            raise ValueError(
                f"lidar {spec.name}: noise_stddev {spec.noise_stddev}, >= 0 m is expected"
            )
        n = int(spec.samples)
        self.spec = spec
        self.angles = np.linspace(spec.min_angle, spec.max_angle, n)
        self.angle_increment = (spec.max_angle - spec.min_angle) / (n - 1) if n > 1 else 0.0
        self.directions = np.column_stack([np.cos(self.angles), np.sin(self.angles), np.zeros(n)])
        self._place = np.asarray(spec.pose[0], dtype=float)  # in the link's frame, as the rays
        self._rays = self.directions @ matrix_from_rpy(spec.pose[1]).T

    def scan(self, engine, link_position, link_orientation, rng=None, own_body=None, too_near=True):
        """One sweep, all rays at the same instant.

        A ray is cast from range_min to range_max, and a short one from the sensor's origin to
        range_min, in which the sensor's own body (its housing) does not count.

        Args:
            engine: has ray_batch(origins (N, 3), targets (N, 3)) -> (fractions, bodies) and
                bodies_in_box(low, high) -> numbers of bodies.
            link_position: (3,) [m], the sensor's link in the world.
            link_orientation: (x, y, z, w), the sensor's link in the world.
            rng: numpy.random.Generator for the noise; needed when noise_stddev > 0.
            own_body: the engine's number of the body that carries the sensor.
            too_near: whether to look for what is nearer than range_min, with as many rays again.

        Returns:
            (n,) float32 [m], min_angle first; +inf: nothing up to range_max; -inf: something
            nearer than range_min (REP 117).
        """
        spec = self.spec
        rotation = matrix_from_quaternion(link_orientation)
        position = np.asarray(link_position, dtype=float) + rotation @ self._place
        rays = self._rays @ rotation.T
        inner = position + spec.range_min * rays
        outer = position + spec.range_max * rays
        fractions, bodies = engine.ray_batch(inner, outer)
        hit = np.asarray(bodies) >= 0
        ranges = spec.range_min + np.asarray(fractions) * (spec.range_max - spec.range_min)
        if spec.noise_stddev > 0.0:
            if rng is None:
                raise ValueError(
                    f"lidar {spec.name}: noise_stddev {spec.noise_stddev} m "
                    "needs a random generator (rng)"
                )
            ranges = ranges + rng.normal(0.0, spec.noise_stddev, len(ranges))
        if spec.noise_stddev > 0.0 or spec.noise_mean:
            ranges = np.clip(ranges + spec.noise_mean, spec.range_min, spec.range_max)
        ranges = np.where(hit, ranges, np.inf)
        looked = too_near and spec.range_min > 0.0
        if looked and self._others_near(engine, position, inner, own_body):
            centre = np.broadcast_to(position, inner.shape)
            _, near = engine.ray_batch(np.ascontiguousarray(centre), inner)
            near = np.asarray(near)
            inside = near >= 0
            if own_body is not None:
                inside &= near != own_body
            ranges[inside] = -np.inf
        return ranges.astype(np.float32)

    @staticmethod
    def _others_near(engine, position, inner, own_body):
        """Whether another body may overlap the box around the sensor and the rays' starts."""
        low = np.minimum(inner.min(axis=0), position)
        high = np.maximum(inner.max(axis=0), position)
        return bool(engine.bodies_in_box(low.tolist(), high.tolist()) - {own_body})
