"""The connection to PyBullet: its parameters, its clock and what is kept of its bodies."""

from bullet_sim.engine.library import p
from bullet_sim.engine.rays import Scenery
from bullet_sim.files import silenced

# Below this sum of squared impulses of an iteration the constraint solver stops early. PyBullet's
# 1e-7 lets a braked car of 25 kg roll on by 1.4 mm a minute; this one by 0.5 mm, at the same speed.
SOLVER_RESIDUAL = 1e-8


class Client:
    """One headless PyBullet client.

    Args:
        time_step: physics step [s].
        gravity: acceleration in the world frame [m/s^2].
        solver_iterations: of the constraint solver per step.
    """

    _renderer = None  # of PyBullet, which draws here: 'egl', 'tiny' or None

    def __init__(self, time_step=0.001, gravity=(0.0, 0.0, -9.81), solver_iterations=50):
        self.time_step = float(time_step)
        self.gravity = tuple(float(g) for g in gravity)
        self._iterations = int(solver_iterations)
        with silenced():
            self._client = p.connect(p.DIRECT)
        self._configure()

    def _configure(self):
        self._movable = {}
        self._free = set()  # bodies whose root link is not fixed
        self._friction, self._scaled = {}, set()  # coefficients that were set, anisotropic links
        self._scenery = Scenery(self._client)
        self._inertial, self._outward = {}, {}  # body -> centre in the root's frame, and back
        self._motors = {}  # see motors()
        self._batches = {}  # body -> last drive_velocities that _motors lacks, and indices
        self.layout = 0  # see states.py
        p.setTimeStep(self.time_step, physicsClientId=self._client)
        p.setGravity(*self.gravity, physicsClientId=self._client)
        p.setPhysicsEngineParameter(
            numSolverIterations=self._iterations,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
            enableConeFriction=1,
            solverResidualThreshold=SOLVER_RESIDUAL,
            physicsClientId=self._client,
        )

    def close(self):
        """Disconnect; the engine is not usable afterwards."""
        if self._client >= 0:
            p.disconnect(physicsClientId=self._client)
            self._client = -1

    def clear(self):
        """Remove every body and return to the state of a new engine."""
        p.resetSimulation(physicsClientId=self._client)
        self._configure()

    def set_gravity(self, gravity):
        """Set gravity [m/s^2] in the world frame."""
        self.gravity = tuple(float(g) for g in gravity)
        p.setGravity(*self.gravity, physicsClientId=self._client)

    def set_time_step(self, time_step):
        """Set the physics step [s]."""
        self.time_step = float(time_step)
        p.setTimeStep(self.time_step, physicsClientId=self._client)

    @property
    def solver_iterations(self):
        """Iterations of the constraint solver per step."""
        return self._iterations

    def set_solver_iterations(self, count):
        """Change the iterations of the constraint solver per step."""
        self._iterations = int(count)
        p.setPhysicsEngineParameter(
            numSolverIterations=self._iterations, physicsClientId=self._client
        )

    def set_contact_breaking(self, share):
        """Change the distance at which a contact point is dropped.

        PyBullet keeps points that no longer touch until they are 0.02 of a shape's radius away;
        each costs three rows of the solver. Rolling wheels drop them sooner with a smaller value:
        the same motion, several times as fast.

        Args:
            share: of the smaller shape's radius.
        """
        p.setPhysicsEngineParameter(contactBreakingThreshold=share, physicsClientId=self._client)

    def _note_batch(self, body):
        """Note the last commands of several motors of a body, before another."""
        for command in zip(*self._batches.pop(body, ())[:3]):
            self._motors[body, command[0]] = "drive_velocity", command

    def motors(self):
        """(body, joint) -> last command of its motor: method, its arguments after the body."""
        for body in list(self._batches):
            self._note_batch(body)
        return self._motors

    def save_state(self):
        """Save poses, velocities and contact caches in memory; returns the number of the copy."""
        return p.saveState(physicsClientId=self._client)

    def restore_state(self, number):
        """Restore a copy of save_state, as long as the bodies are the same; motors stay."""
        self._scenery.check_poses()
        p.restoreState(stateId=number, physicsClientId=self._client)

    def link_velocity(self, body, link):
        """Centre of mass (3,) [m] of a link, and its linear and angular velocity; world axes.

        Args:
            link: index as link_indices gives it.

        Returns:
            centre, linear [m/s], angular [rad/s], and the pose (position, quaternion) of the
            frame that PyBullet keeps: of the root link that of its inertia, else the link's own.
        """
        if link < 0:
            place = p.getBasePositionAndOrientation(body, physicsClientId=self._client)
            return place[0], *p.getBaseVelocity(body, physicsClientId=self._client), place
        state = p.getLinkState(
            body,
            link,
            computeLinkVelocity=1,
            computeForwardKinematics=1,
            physicsClientId=self._client,
        )
        return state[0], state[6], state[7], state[4:6]

    def step(self, count=1):
        """Advance by `count` time steps."""
        step, client = p.stepSimulation, self._client
        for _ in range(count):
            step(client)
