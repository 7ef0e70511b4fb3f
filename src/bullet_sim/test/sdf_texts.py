"""SDF texts for tests: a world of a floor, a sound model and odd ones; static meshes."""

import math

import numpy as np
import trimesh
from bullet_sim.description.warnings import grouped
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.world import World

INERTIA = "<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia>"
MASS = f"<inertial><mass>1</mass>{INERTIA}</inertial>"
BOX = '<collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>'
SOUND = f'<model name="sound"><pose>5 0 3 0 0 0</pose><link name="l">{MASS}{BOX}</link></model>'
FLOOR = "<include><uri>model://ground_plane</uri></include>"
NAN_INERTIA = "<inertia><ixx>nan</ixx><iyy>nan</iyy><izz>nan</izz></inertia>"
FALLEN = 3 - 0.5 * 9.81 * 0.2**2  # [m] height of the sound model after 0.2 s


def world_of(content, version="1.6"):
    """WorldDescription of a floor, a sound model and others."""
    text = f'<sdf version="{version}">\n<world name="w">\n{FLOOR}{SOUND}\n{content}\n</world></sdf>'

    def resolve(uri):
        raise ValueError("searched nowhere")

    return parse_world(text, resolve, "/tmp/my.world")


def model(content="", link="", pose="0 0 1 0 0 0", inertial=MASS):
    """A model of one link and what else it holds."""
    inside = f'<pose>{pose}</pose><link name="a">{inertial}{link}</link>{content}'
    return f'<model name="m">{inside}</model>'


def read(world, name="m"):
    """A model's description."""
    return next(found for found, _ in world.models if found.name == name)


def weighing(mass="<mass>1</mass>", inertia=INERTIA):
    """A model with an <inertial>."""
    return model(inertial=f"<inertial>{mass}{inertia}</inertial>")


def fallen(text):
    """The sound model's height after 0.2 s in a world, which must stay finite."""
    world = World()
    try:
        for line in grouped(world.load(world_of(text))):
            assert line
        world.step(round(0.2 / world.time_step))
        for found in world.models.values():
            assert all(map(math.isfinite, found.pose.position)), found.name
            assert np.linalg.norm(found.pose.position) < 100, found.name
        return world.models["sound"].pose.position[2]
    finally:
        world.close()


def static_mesh(name, folder):
    """SDF of a static model of the file NAME.stl."""
    return (
        f'<sdf version="1.6"><model name="{name}"><static>1</static><link name="l"><collision '
        f'name="c"><geometry><mesh><uri>file://{folder}/{name}.stl</uri></mesh></geometry>'
        "</collision></link></model></sdf>"
    )


def write_triangles(path, triangles):
    """Writes a mesh of triangles (n, 3, 3) [m] as they are."""
    vertices = np.asarray(triangles, float).reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    trimesh.Trimesh(vertices, faces, process=False).export(path)
