"""Bodies and worlds of the contact tests."""

import math

from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import joint, link, robot, tags

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
    surface = {"mu1": mu, "mu2": mu, **({"fdir1": fdir1} if fdir1 else {})}
    x, y, z = 2 * half_base, 1.9 * half_track, 0.1
    i = [mass / 12.0 * (a * a + b * b) for a, b in ((y, z), (x, z), (x, y))]
    shape = f'<sphere radius="{radius}"/>'
    if not round_wheels:
        shape = f'<cylinder radius="{radius}" length="0.04"/>'
    spin, limit = wheel_mass * radius**2 / 2, f'<limit effort="{effort}" velocity="0"/>'
    parts = [link("base", mass, tuple(i))]
    for end, ax in (("f", half_base), ("r", -half_base)):
        for side, ay in (("l", half_track), ("r", -half_track)):
            name = end + side
            moments = (spin / 2, spin, spin / 2)
            parts += [
                link(name, wheel_mass, moments, shape, f"{HALF_PI} 0 0"),
                joint(name, "continuous", "base", name, f"{ax} {ay} 0", more=limit),
                tags(name, **surface),
            ]
    return parse_urdf(robot(*parts), nowhere, "skid")


def world_of(*models, gravity=(0.0, 0.0, -9.81), step=0.001, solver="ode"):
    """A World with (description, Pose) pairs in it."""
    world = World(step, gravity, solver=solver)
    for description, pose in models:
        world.spawn(description, pose or Pose())
    return world
