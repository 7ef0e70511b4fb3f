"""Motors of a model's joints that follow what a test says, within the joints' limits."""

from bullet_sim.controllers.limits import JointLimits


def drive_velocities(joints, names, values):
    """Have joints follow velocities [rad/s, m/s]."""
    for name, value in zip(names, values):
        limits = JointLimits(joints.limits[name])
        joints.motor(name).track_velocity(limits.velocity(value), limits.max_effort)


def drive_positions(joints, names, values):
    """Have joints follow positions [rad, m]."""
    for name, value in zip(names, values):
        joints.motor(name).track_position(*JointLimits(joints.limits[name]).position_command(value))
