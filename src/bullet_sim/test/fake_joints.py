"""Joints without an engine, for controllers, and bases that drive on such."""

from bullet_sim.controllers.manager import Manager
from bullet_sim.engine.quickstep.law import effort_of

# what controllers of bases cannot be loaded without
COVARIANCES = {f"{of}_covariance_diagonal": [0.0] * 6 for of in ("pose", "twist")}


def limited_effort(handle):
    """The effort of a JointHandle within the joint's limits, and what of it acts."""
    row = handle.effort_row(computes=False)
    acts = effort_of(row.numbers, handle.position, handle.velocity, 0.001)
    return row.applied, acts


class FakeJoints:
    """Joints that do exactly what they are told; subclasses have `names` and `limits`.

    Attributes:
        positions, speeds: [rad, m] and [rad/s, m/s] by name.
        applied: efforts [N m, N] of the last step by name.
    """

    names, limits = (), {}

    def __init__(self):
        self.positions = dict.fromkeys(self.names, 0.0)
        self.speeds = dict.fromkeys(self.names, 0.0)
        self.applied = {}

    def state(self):
        """Positions and velocities."""
        return dict(self.positions), dict(self.speeds)

    def read(self, handles):
        """As Joints.read."""
        positions, velocities = self.state()
        for handle in handles:
            handle.position, handle.velocity = positions[handle.name], velocities[handle.name]

    def drive_positions(self, names, values):
        """Be there at once."""
        self.positions.update(zip(names, values))

    def drive_velocities(self, names, values):
        """Move from now on."""
        self.speeds.update(zip(names, values))

    def motor(self, name):
        """As Joints.motor."""
        return FakeMotor(self, name)

    def apply_efforts(self, handles, computes=False):
        """Record."""
        self.applied = {handle.name: handle.effort for handle in handles}

    def release(self, names):
        """Stand still."""
        self.speeds.update(dict.fromkeys(names, 0.0))

    def move(self, period):
        """Move for a time [s]."""
        for name, speed in self.speeds.items():
            self.positions[name] += speed * period


class FakeMotor:
    """Motor of one of the joints."""

    def __init__(self, joints, name):
        self._joints, self._name = joints, name

    def track_velocity(self, velocity, _effort):
        """As Motor's."""
        self._joints.drive_velocities((self._name,), (velocity,))

    def track_position(self, position, _effort, _speed):
        """As Motor's."""
        self._joints.drive_positions((self._name,), (position,))

    def release(self):
        """As Motor's."""
        self._joints.release((self._name,))


class Base:
    """A manager with one running controller, 'base', of a base that drives."""

    def __init__(self, joints, description, config):
        self.joints, self.manager = joints, Manager(joints, description)
        self.config = self.manager.load("base", {**COVARIANCES, **config})
        self.manager.switch(["base"], [])
        self.controller = self.manager.get("base")

    def run(self, seconds, command=None):
        """Simulate; a command is repeated every 0.1 s. Returns the odometry."""
        for step in range(round(seconds / 0.001)):
            if command is not None and step % 100 == 0:
                self.manager.command("base", command)
            self.manager.update(0.001)
            self.joints.move(0.001)
        self.manager.observe()
        return self.controller.odometry
