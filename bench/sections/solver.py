"""Steps of the solver 'ode' over those of 'bullet' in the same scene, and scans of a lidar; no ROS.

The scenes are what has made worlds slow: things at rest and awake, links that collide with each
other, static meshes, a lidar among many bodies. Two more rows are steps with controllers, in calls
of many over calls of one, before each of which Python updates them. The last row is a world of cars
with island_threads over the same without.
"""

import math
import os
import pathlib
import tempfile
from dataclasses import replace

import numpy as np
import xacro
from bullet_sim.engine.api import Rays
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.pose import Pose
from bullet_sim.world import World
from pairs import alternate, pairs_of, rate_of_work
from report import ratio_row
from usage import Monitor
from worlds.core import GROUND, INERTIAL, car, hills

SECONDS, STEPS = 0.4, 50  # of a round, of a call
SETTLE = 2.5  # [s] until things sleep
SPEED = 8.0  # [rad/s] of the car's wheels
RAYS, FAR = 720, 10.0  # of the lidar, [m]
CARS, ISLAND_THREADS = 16, 2
SOURCES = pathlib.Path(__file__).resolve().parents[2] / "src"


def thing(shape, mass, moment, awake):
    """SDF of a loose thing."""
    return (
        '<sdf version="1.6"><model name="thing"><allow_auto_disable>'
        f'{int(not awake)}</allow_auto_disable><link name="link">{INERTIAL.format(mass, moment)}'
        f'<collision name="c"><geometry>{shape}</geometry></collision></link></model></sdf>'
    )


POST = "<box><size>0.04 0.04 0.4</size></box>", 0.2, 0.002
CAN = "<cylinder><radius>0.05</radius><length>0.1</length></cylinder>", 0.2, 2e-4


def ring(world, count, shape, awake):
    """Things on circles around the car, at least half a meter from it and from each other."""
    for number in range(count):
        radius, angle = 1.5 + number // 16, 2.0 * math.pi * (number % 16) / 16
        at = (radius * math.cos(angle), radius * math.sin(angle))
        height = 0.2 if shape is POST else 0.05
        world.spawn_sdf(f"thing{number}", thing(*shape, awake), Pose((*at, height)), str)


def meshes(world, folder):
    """300 static meshes around the car."""
    path = hills(pathlib.Path(folder, "rock.obj"), 4)
    text = (
        '<sdf version="1.6"><model name="rock"><static>true</static><link name="link"><collision '
        f'name="c"><geometry><mesh><uri>{path}</uri><scale>0.01 0.01 0.1</scale></mesh></geometry>'
        "</collision></link></model></sdf>"
    )
    for number in range(300):
        at = (2.0 + number // 20, 0.7 * (number % 20) - 7.0, 0.0)
        world.spawn_sdf(f"rock{number}", text, Pose(at), lambda uri: uri)


SCENES = {
    "a car": lambda world, folder: None,
    "a car, 80 posts at rest": lambda world, folder: ring(world, 80, POST, False),
    "a car, 40 cans awake": lambda world, folder: ring(world, 40, CAN, True),
    "a car, 300 static meshes": meshes,
}


def made(solver, scene, folder):
    """A world of a scene in which the car turns on the spot."""
    world = World(solver=solver)
    world.spawn_sdf("ground", GROUND, Pose(), str)
    SCENES[scene](world, folder)
    model = world.spawn_urdf("car", car(), Pose((0.0, 0.0, 0.03)), str)
    world.step(round(SETTLE / world.time_step))
    names = model.joints.names
    for name, speed in zip(names, [-SPEED, SPEED, -SPEED, SPEED]):
        model.joints.motor(name).track_velocity(speed, model.joints.max_effort(name))
    world.step(STEPS)
    return world


CONTROL = '<gazebo><plugin name="control" filename="libgazebo_ros_control.so"/></gazebo></robot>'
PIDS = {"p": 0.05, "i": 0.1, "i_clamp": 0.01}


def controllers(kind, names):
    """Configurations of controllers of the car's wheels, by their names."""
    if kind == "four PIDs":
        by_effort = "effort_controllers/JointVelocityController"
        return {name: {"type": by_effort, "joint": name, "pid": PIDS} for name in names}
    sides = {"left_wheel": list(names[::2]), "right_wheel": list(names[1::2])}
    sizes = {"wheel_separation": 0.3, "wheel_radius": 0.03, "cmd_vel_timeout": 1e9}
    sizes.update({f"{of}_covariance_diagonal": [0.0] * 6 for of in ("pose", "twist")})
    return {"base": {"type": "diff_drive_controller/DiffDriveController", **sides, **sizes}}


def controlled(kind):
    """A world of the solver 'ode' in which controllers drive the car."""
    world = World(solver="ode")
    world.spawn_sdf("ground", GROUND, Pose(), str)
    text = car().replace("</robot>", CONTROL)
    manager = world.spawn_urdf("car", text, Pose((0.0, 0.0, 0.03)), str).manager
    found = controllers(kind, manager.hardware.names)
    for name, config in found.items():
        manager.load(name, config)
    manager.switch(list(found), [])
    for name in found:
        manager.command(name, [0.2, 0.3] if name == "base" else [SPEED])
    world.step(STEPS)
    return world


def many_cars(threads):
    """A world of 16 of our cars, as launched, that turn, with a number of island_threads."""
    world = World(solver="ode")
    text = (SOURCES / "track_model" / "worlds" / "track.world").read_text(encoding="utf-8")
    settings = replace(parse_world(text, str).ode, island_threads=threads)
    world.engine.configure(settings)
    world.spawn_sdf("ground", GROUND, Pose(), str)
    urdf = xacro.process_file(str(SOURCES / "track_model" / "urdf" / "racecar.urdf.xacro")).toxml()
    for number in range(CARS):
        at = Pose((2.0 * (number % 4), 2.0 * (number // 4), 0.05))
        joints = world.spawn_urdf(
            f"car{number}", urdf, at, lambda uri: uri.replace("package://", f"{SOURCES}/")
        ).joints
        for name in (name for name in joints.names if "wheel" in name):
            speed = SPEED if "left" in name else -SPEED
            joints.motor(name).track_velocity(speed, joints.max_effort(name))
    world.step(STEPS)
    return world


def stepping(world, count=STEPS):
    """Function of a round of steps, of which a call makes a number."""

    def work():
        for _ in range(STEPS // count):
            world.step(count)
        return STEPS

    return lambda: rate_of_work(work, SECONDS)


def scanning(world):
    """Function of a round of scans of a level lidar above the car."""
    angles = np.linspace(-math.pi, math.pi, RAYS)
    rays = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(RAYS)])
    center = np.array((0.0, 0.0, 0.15))

    def work():
        world.engine.cast_rays(Rays(center, rays, 0.1, FAR))
        return 1

    return lambda: rate_of_work(work, SECONDS)


def measure(quick, _log):
    """Pairs of rounds of both solvers in each scene, and of scans among 80 posts."""
    found, monitor = {}, Monitor({"bench": [os.getpid()]})
    for scene in SCENES:
        with tempfile.TemporaryDirectory() as folder:
            worlds = [made(solver, scene, folder) for solver in ("bullet", "ode")]
            try:
                kinds = {f"steps, {scene}": stepping}
                if "80 posts" in scene:
                    kinds[f"scans, {scene}"] = scanning
                for name, kind in kinds.items():
                    its, mine = map(kind, worlds)
                    pairs = alternate(its, {"ode": mine}, pairs_of(quick), monitor)["ode"]
                    found[name] = pairs.figures()
            finally:
                for world in worlds:
                    world.close()
    for kind in ("four PIDs", "diff_drive_controller"):
        world = controlled(kind)
        many = {"many": stepping(world)}
        pairs = alternate(stepping(world, 1), many, pairs_of(quick), monitor)["many"]
        found[f"many steps a call, {kind}"] = pairs.figures()
        world.close()
    worlds = [many_cars(threads) for threads in (0, ISLAND_THREADS)]
    one, several = map(stepping, worlds)
    pairs = alternate(one, {"several": several}, pairs_of(quick), monitor)["several"]
    found[f"{ISLAND_THREADS} island_threads, {CARS} cars"] = pairs.figures()
    for world in worlds:
        world.close()
    return {"rows": found}


def rows(figures):
    """The ratios."""
    for name, row in figures["rows"].items():
        unit = "scans per s" if name.startswith("scans") else "steps per s"
        over = "one step a call" if name.startswith("many") else "the solver bullet's"
        over = "no island_threads" if "island_threads" in name else over
        yield ratio_row(f"ode, {name}", row, over, unit)
