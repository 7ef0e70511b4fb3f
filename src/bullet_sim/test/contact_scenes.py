"""Bodies and worlds of the contact tests."""

import math

from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

HALF_PI = 1.5707963267948966
SLIDE_TIME = 0.6  # [s]


def nowhere(uri):
    raise OSError(f"{uri} is not there")


def sdf_box(name, size, mass=1.0, surface="", static=False, more=""):
    """ModelDescription of a box; `surface` is what stands in its <surface>."""
    x, y, z = size
    i = [mass / 12.0 * (a * a + b * b) for a, b in ((y, z), (x, z), (x, y))]
    text = (
        f'<sdf version="1.6"><model name="{name}"><static>{str(static).lower()}</static>'
        f'<link name="l">{more}<inertial><mass>{mass}</mass><inertia><ixx>{i[0]}</ixx>'
        f"<iyy>{i[1]}</iyy><izz>{i[2]}</izz></inertia></inertial>"
        f'<collision name="c"><geometry><box><size>{x} {y} {z}</size></box></geometry>'
        f"<surface>{surface}</surface></collision></link></model></sdf>"
    )
    return parse_model(text, nowhere, name)[0]


def friction(mu, mu2=None, fdir1=None):
    """<friction> of SDF."""
    text = f"<mu>{mu}</mu><mu2>{mu if mu2 is None else mu2}</mu2>"
    text += "" if fdir1 is None else f"<fdir1>{fdir1}</fdir1>"
    return f"<friction><ode>{text}</ode></friction>"


def ground(mu=1.0):
    """ModelDescription of an endless floor at z = 0."""
    text = (
        '<sdf version="1.6"><model name="floor"><static>true</static><link name="l">'
        '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry>'
        f"<surface>{friction(mu)}</surface></collision></link></model></sdf>"
    )
    return parse_model(text, nowhere, "floor")[0]


def slid(box_surface, ground_mu, slope, along="x", yaw=0.0, solver="ode"):
    """How far [m] a box slides in SLIDE_TIME on a floor that is inclined by atan(slope)."""
    angle = math.atan(slope)
    down = 9.81 * math.sin(angle)
    gravity = (down if along == "x" else 0.0, down if along == "y" else 0.0)
    box = sdf_box("box", (0.4, 0.4, 0.04), surface=box_surface)
    pose = Pose.from_xyz_rpy((0, 0, 0.02), (0, 0, yaw))
    places = (ground(ground_mu), None), (box, pose)
    world = world_of(*places, gravity=(*gravity, -9.81 * math.cos(angle)), solver=solver)
    world.step(round(SLIDE_TIME / world.time_step))
    x, y, _ = world.models["box"].pose.position
    world.close()
    return math.hypot(x, y)


def expected_slide(mu, slope):
    """Closed form of the same: a = g (sin - mu cos), 0 where it sticks."""
    angle = math.atan(slope)
    acceleration = 9.81 * (math.sin(angle) - mu * math.cos(angle))
    return max(0.0, 0.5 * acceleration * SLIDE_TIME**2)


def skid_base(
    mass, half_base, half_track, radius, wheel_mass, mu=0.8, round_wheels=True, effort=0, fdir1=""
):
    """ModelDescription of a base with four driven wheels.

    Args:
        mass, wheel_mass: [kg].
        half_base, half_track: wheels stand at (+-half_base, +-half_track) [m].
        radius: of the wheels [m].
        round_wheels: spheres, else cylinders 4 cm wide.
        effort: limit of each wheel [N m].
        fdir1: first direction of the wheels' friction; empty: none given.
    """
    direction = f"<fdir1>{fdir1}</fdir1>" if fdir1 else ""
    x, y, z = 2 * half_base, 1.9 * half_track, 0.1
    i = [mass / 12.0 * (a * a + b * b) for a, b in ((y, z), (x, z), (x, y))]
    shape = f'<sphere radius="{radius}"/>'
    if not round_wheels:
        shape = f'<cylinder radius="{radius}" length="0.04"/>'
    spin = wheel_mass * radius**2 / 2
    text = (
        f'<robot name="skid"><link name="base"><inertial><mass value="{mass}"/><inertia '
        f'ixx="{i[0]}" iyy="{i[1]}" izz="{i[2]}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )
    for name, ax, ay in (
        ("fl", half_base, half_track),
        ("fr", half_base, -half_track),
        ("rl", -half_base, half_track),
        ("rr", -half_base, -half_track),
    ):
        text += (
            f'<link name="{name}"><inertial><mass value="{wheel_mass}"/><inertia ixx="{spin / 2}" '
            f'iyy="{spin}" izz="{spin / 2}" ixy="0" ixz="0" iyz="0"/></inertial><collision><origin '
            f'rpy="{HALF_PI} 0 0"/><geometry>{shape}</geometry></collision></link>'
            f'<joint name="{name}" type="continuous"><parent link="base"/><child link="{name}"/>'
            f'<origin xyz="{ax} {ay} 0"/><axis xyz="0 1 0"/><limit effort="{effort}" '
            f'velocity="0"/></joint><gazebo reference="{name}"><mu1>{mu}</mu1><mu2>{mu}</mu2>'
            f"{direction}</gazebo>"
        )
    return parse_urdf(text + "</robot>", nowhere, "skid")


def world_of(*models, gravity=(0.0, 0.0, -9.81), step=0.001, solver="ode"):
    """A World with (description, Pose) pairs in it."""
    world = World(step, gravity, solver=solver)
    for description, pose in models:
        world.spawn(description, pose or Pose())
    return world
