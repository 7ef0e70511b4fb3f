"""Positions and velocities of joints: those that are measured, and those that are imposed."""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.screws import measure_screw, turned
from bullet_sim.engine.quickstep.state import System
from bullet_sim.engine.quickstep.vectors import copy, cross, matrix, multiply, rotate


@compiled
def impose(step: float, system: System) -> None:
    """Put and move what is below joints with a commanded position or an imposed velocity."""
    joints = system.joints
    for j in range(len(joints)):
        target = joints[j, col.TARGET]
        if target == target:  # a number
            reach = joints[j, col.MAX_SPEED] * step
            reached = joints[j, col.REACHED]
            joints[j, col.REACHED] = reached + min(max(target - reached, -reach), reach)
            _set_position(j, joints[j, col.REACHED], system)
        velocity = joints[j, col.IMPOSED]
        if velocity == velocity:
            _set_velocity(j, velocity, system)


@compiled
def _set_position(j: int, position: float, system: System) -> None:
    """Put what is below a joint where a position says."""
    rotation, axis, anchor, arm = temporary(9), temporary(3), temporary(3), temporary(3)
    turn, quaternion = temporary(4), temporary(4)
    bodies, joint, kind = system.bodies, system.joints[j], system.types[j, 0]
    change = position - joint[col.ANGLE]
    if change == 0.0:
        return
    joint[col.ANGLE] = position
    first = system.types[j, 1]
    matrix(bodies[first, col.QUAT : col.QUAT + 4], rotation)
    rotate(rotation, joint[col.AXIS1 : col.AXIS1 + 3], axis)
    rotate(rotation, joint[col.ANCHOR1 : col.ANCHOR1 + 3], anchor)
    for k in range(3):
        anchor[k] += bodies[first, col.POS + k]
    shift = change if kind == col.SLIDER else 0.0
    if kind == col.SCREW:
        shift = change / joint[col.PITCH]
    if kind != col.SLIDER:
        sine = math.sin(0.5 * change)
        turn[0], turn[1], turn[2] = axis[0] * sine, axis[1] * sine, axis[2] * sine
        turn[3] = math.cos(0.5 * change)
        matrix(turn, rotation)
    for b in range(len(bodies)):
        if not system.below[j, b]:
            continue
        if kind != col.SLIDER:
            for k in range(3):
                arm[k] = bodies[b, col.POS + k] - anchor[k]
            rotate(rotation, arm, arm)
            for k in range(3):
                bodies[b, col.POS + k] = anchor[k] + arm[k]
            multiply(turn, bodies[b, col.QUAT : col.QUAT + 4], quaternion)
            copy(quaternion, bodies[b, col.QUAT : col.QUAT + 4])
        if shift != 0.0:
            for k in range(3):
                bodies[b, col.POS + k] += shift * axis[k]


@compiled
def _set_velocity(j: int, velocity: float, system: System) -> None:
    """Give the body below a joint the motion of the one above, and a velocity along the joint.

    As Gazebo's Joint::SetVelocity.
    """
    rotation, axis, arm, turn = temporary(9), temporary(3), temporary(3), temporary(3)
    bodies, joint = system.bodies, system.joints[j]
    first, second = system.types[j, 1], system.types[j, 2]
    child = bodies[first]
    matrix(child[col.QUAT : col.QUAT + 4], rotation)
    rotate(rotation, joint[col.AXIS1 : col.AXIS1 + 3], axis)
    for k in range(3):
        child[col.VEL + k] = bodies[second, col.VEL + k] if second >= 0 else 0.0
    if system.types[j, 0] == col.SLIDER:
        for k in range(3):
            child[col.VEL + k] += velocity * axis[k]
        return
    for k in range(3):
        spin = bodies[second, col.VEL + 3 + k] if second >= 0 else 0.0
        child[col.VEL + 3 + k] = spin + velocity * axis[k]
    rotate(rotation, joint[col.ANCHOR1 : col.ANCHOR1 + 3], arm)
    cross(arm, child[col.VEL + 3 : col.VEL + 6], turn)
    for k in range(3):
        child[col.VEL + k] += turn[k]
    if second >= 0:
        matrix(bodies[second, col.QUAT : col.QUAT + 4], rotation)
        rotate(rotation, joint[col.ANCHOR2 : col.ANCHOR2 + 3], arm)
        cross(bodies[second, col.VEL + 3 : col.VEL + 6], arm, turn)
        for k in range(3):
            child[col.VEL + k] += turn[k]


@compiled
def measure(system: System) -> None:
    """Positions and velocities of the joints; positions of hinges count whole rotations."""
    rotation, axis, a2, bodies = temporary(9), temporary(3), temporary(3), system.bodies
    for j in range(len(system.joints)):
        kind, one, two = system.types[j, 0], system.types[j, 1], system.types[j, 2]
        joint = system.joints[j]
        matrix(bodies[one, col.QUAT : col.QUAT + 4], rotation)
        rotate(rotation, joint[col.AXIS1 : col.AXIS1 + 3], axis)
        shift = 3 if kind == col.HINGE else 0
        rate = 0.0
        for k in range(3):
            relative = bodies[one, col.VEL + shift + k]
            if two >= 0:
                relative -= bodies[two, col.VEL + shift + k]
            rate += axis[k] * relative
        if kind == col.HINGE:
            relative, own = joint[col.QREL : col.QREL + 4], joint[col.AXIS1 : col.AXIS1 + 3]
            joint[col.ANGLE] = turned(one, two, relative, own, joint[col.ANGLE], bodies)
        elif kind == col.SLIDER:
            position = 0.0
            for k in range(3):
                a2[k] = joint[col.ANCHOR2 + k]
            if two >= 0:
                matrix(bodies[two, col.QUAT : col.QUAT + 4], rotation)
                rotate(rotation, joint[col.ANCHOR2 : col.ANCHOR2 + 3], a2)
                for k in range(3):
                    a2[k] += bodies[two, col.POS + k]
            for k in range(3):
                position += axis[k] * (bodies[one, col.POS + k] - a2[k])
            joint[col.ANGLE] = position
        joint[col.RATE] = rate
    for j in range(len(system.joints)):
        if system.types[j, 0] == col.SCREW:
            measure_screw(j, system)
