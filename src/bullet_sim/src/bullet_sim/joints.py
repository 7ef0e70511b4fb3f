"""A robot's movable joints: names, limits, state as arrays, and motors by joint name."""

UNLIMITED_EFFORT = 1e6      # [N m, N] where the URDF gives no limit
UNLIMITED_SPEED = 1e4       # [rad/s, m/s]


class Joints:
    """Movable joints of one body.

    Args:
        engine: the Engine.
        body: body number.
        joints: bullet_sim.description.Joint list.
    """

    def __init__(self, engine, body, joints):
        self._engine, self._body = engine, body
        by_name = {joint.name: joint for joint in joints}
        self._engine_order = engine.joint_names(body)
        self._index = {name: i for i, name in enumerate(self._engine_order)}
        self.names = tuple(by_name)
        self.limits = by_name
        self._permutation = [self._index[name] for name in self.names]

    def rebind(self, body):
        """Go on with a re-loaded body."""
        self._body = body

    def read(self):
        """Positions [rad, m], velocities, efforts [N m, N]: three (n,) arrays in names' order."""
        order = self._permutation
        return tuple(values[order] for values in self._engine.read_joints(self._body))

    def positions_of(self, names):
        """Positions of some joints, as a tuple."""
        positions = self._engine.read_joints(self._body)[0]
        return tuple(float(positions[self._index[name]]) for name in names)

    def set_positions(self, values):
        """Put joints (mapping name -> position) there, at rest; the others keep theirs."""
        positions = self._engine.read_joints(self._body)[0]
        for name, value in values.items():
            positions[self._index[name]] = value
        self._engine.set_joint_positions(self._body, positions)

    def _effort(self, name):
        return self.limits[name].effort or UNLIMITED_EFFORT

    def _speed(self, name):
        return self.limits[name].velocity or UNLIMITED_SPEED

    def drive_velocities(self, names, values):
        """Track velocities, clipped to the URDF's velocity limits."""
        for name, value in zip(names, values):
            speed = self._speed(name)
            self._engine.drive_velocity(self._body, self._index[name],
                                        min(max(value, -speed), speed), self._effort(name))

    def drive_positions(self, names, values):
        """Track positions, clipped to the URDF's position limits."""
        for name, value in zip(names, values):
            limits = self.limits[name]
            if limits.lower is not None:
                value = min(max(value, limits.lower), limits.upper)
            self._engine.drive_position(self._body, self._index[name], value,
                                        self._effort(name), self._speed(name))

    def release(self, names):
        """Leave joints to their own friction."""
        for name in names:
            self._engine.release(self._body, self._index[name])
