"""Small robots with one feature each, what is done with them, and where Gazebo 11.1 had their base.

bench/states_beside_gazebo.py makes worlds of them for Gazebo and records gazebo_states.json.
"""

import json
import math
import struct
import zlib
from pathlib import Path

from urdf_texts import joint, link, robot, tags

RECORD = Path(__file__).with_name("gazebo_states.json")
STEPS, EVERY = 500, 100  # made in all, between two recorded states
# Fewer, where contacts of edges, or of depth 0, are there or not by the rounding of a number: from
# then on all depends on it.
UNTIL = {
    "meshes on a mesh": 400,
    "a tilted box on a mesh": 200,
    "meshes on a box": 200,
    "meshes as wheels on hills": 300,  # Gazebo's rays at meshes have single precision
    "meshes push a crate": 300,
    "meshes push a can": 400,
    "meshes against a post": 300,
    "wheels against a wedge": 300,
    "a tilted box in a tray": 300,
    "a car in a tray": 200,
    "velocities that decay": 300,
    "a merged link without gravity on a box": 400,
    "a sled against blocks": 400,
    "a sled against blocks on a box": 300,
}
# Starts [m, along x and z], of which one has to be alike, of robots that such a difference sends
# another way: an edge of their box is on an edge of the ground, or is not; a bit more is 1 um.
STARTS = {
    "a tilted box on a mesh": (0.0, 1e-16, 2e-16, 3e-16),
    "a tilted box in a tray": (0.0, 1e-16, 2e-16, 3e-16),
    "cylinders on a mesh": (0.0, 1e-16, 2e-16, 3e-16),
}
GRAVITY = (0.0, 0.0, -9.8)  # [m/s^2] a world's in Gazebo that gives none
CORNERS = {"fl": (0.2, 0.2), "fr": (0.2, -0.2), "rl": (-0.2, 0.2), "rr": (-0.2, -0.2)}


def wheel(name, x, y, parent="base", shape=""):
    """A wheel of 10 cm; its joint is NAME_joint."""
    cylinder = '<cylinder radius="0.1" length="0.05"/>'
    return link(
        name, 0.5, (0.0014, 0.0025, 0.0014), shape or cylinder, "0 0 0" if shape else "1.5708 0 0"
    ) + joint(f"{name}_joint", "continuous", parent, name, f"{x} {y} 0")


def in_gazebo(name, kind, parent, child, at="0 0 0", axis="0 1 0"):
    """A joint of SDF within a URDF."""
    return (
        f'<gazebo><joint name="{name}" type="{kind}"><pose>{at} 0 0 0</pose>'
        f"<parent>{parent}</parent><child>{child}</child><axis><xyz>{axis}</xyz></axis>"
        "</joint></gazebo>"
    )


BASE = link("base", 8.0, 0.1, '<box size="0.4 0.3 0.08"/>', center="0.03 0 0.02")
BALLS = "".join(
    wheel(name, *place, shape='<sphere radius="0.1"/>') for name, place in CORNERS.items()
)
TILTED = BASE.replace("<collision><origin rpy=", '<collision><origin xyz="0.01 0 0" rpy=').replace(
    'rpy="0 0 0"/><geometry>', 'rpy="0.2 0.1 0.3"/><geometry>'
)
# an arm of two links that falls on the base, with which no joint connects it; it alone collides
ARM_ON_BASE = (
    link("upper", 0.3, 1e-3)
    + joint("shoulder", "revolute", "base", "upper", "0 0 0.17",
            more='<limit lower="0" upper="0.001" effort="10" velocity="1"/>')
    + link("fore", 0.4, 2e-3, '<box size="0.3 0.04 0.04"/>', center="0.1 0 0")
    + joint("elbow", "continuous", "upper", "fore", "-0.1 0.02 0")
    + tags("fore", selfCollide="true")
)  # fmt: skip
WEAK = '<limit effort="0.5" velocity="1"/><dynamics friction="0.05" damping="0.01"/>'
WHEELS = "".join(wheel(name, *place) for name, place in CORNERS.items())


def turn(names=tuple(CORNERS), left=3.0, right=5.0, at=200, kind="velocity"):
    """Commands of wheels, at a step: of the left ones and of the right ones [rad/s]."""
    return [(at, f"{name}_joint", kind, left if name[-1] == "l" else right, 20.0) for name in names]


def on_a_castor(x, ball, behind, **surface):
    """A base on two wheels at x and a ball, a link that a fixed joint holds."""
    wheels = wheel("l", x, 0.2), wheel("r", x, -0.2)
    held = joint("held", "fixed", "base", "ball", f"{behind} 0 -0.05")
    return robot(BASE, *wheels, ball, held, tags("ball", **surface))


def on_the_base(name, shape, *places):
    """Links that fixed joints hold on the base, so that it has several shapes."""
    return [
        link(f"{name}_{i}", 0.2, 1e-3, shape)
        + joint(f"{name}_{i}_joint", "fixed", "base", f"{name}_{i}", " ".join(map(str, at)))
        + tags(f"{name}_{i}", mu1=0.05, mu2=0.05)
        for i, at in enumerate(places)
    ]


def with_bumpers(*places):
    """A car with blocks in front, which drives straight on."""
    car = robot(BASE, WHEELS, *on_the_base("bumper", BLOCK, *places))
    return car, 0.12, turn(left=4.0, right=4.0)


def hinges(names, more):
    """Wheels of which some are on knuckles that steer."""
    return "".join(
        link(f"s{name}", 0.05, 1e-5)
        + joint(f"s{name}_joint", "revolute", "base", f"s{name}", f"{x} {y} 0", "0 0 1", more)
        + wheel(name, 0, 0, f"s{name}")
        for name, (x, y) in CORNERS.items()
        if name in names
    ) + "".join(wheel(name, *CORNERS[name]) for name in CORNERS if name not in names)


def springs():
    """Each wheel on a slider with a damper."""
    limit = '<limit lower="-0.05" upper="0.05" effort="1000" velocity="3"/><dynamics damping="20"/>'
    return "".join(
        link(f"s{name}", 0.3, 1e-3)
        + joint(f"s{name}_joint", "prismatic", "base", f"s{name}", f"{x} {y} 0", "0 0 1", limit)
        + wheel(name, 0, 0, f"s{name}")
        for name, (x, y) in CORNERS.items()
    )


def wheel_triangles():
    """A wheel of 24 sides."""
    triangles = []
    for i in range(24):
        a, b = math.pi * i / 12, math.pi * (i + 1) / 12
        rim = [(0.1 * math.cos(t), y, 0.1 * math.sin(t)) for y in (-0.025, 0.025) for t in (a, b)]
        triangles += [(rim[0], rim[2], rim[3]), (rim[0], rim[3], rim[1])]
        triangles += [((0, -0.025, 0), rim[0], rim[1]), ((0, 0.025, 0), rim[3], rim[2])]
    return triangles


def waves():
    """A ground of 18 x 18 squares of 25 cm, not higher than 0."""

    def at(i, j):
        x, y = 0.25 * i - 2.21, 0.25 * j - 2.33
        return x, y, 0.03 * (math.sin(1.7 * x) * math.cos(1.3 * y) - 1.0)

    triangles = []
    for i in range(18):
        for j in range(18):
            a, b, c, d = at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)
            triangles += [(a, b, d), (a, d, c)]
    return triangles


def block(low, high):
    """The triangles of a box from its lower to its upper corner."""
    corners = [[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)]
    sides = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    quads = [[corners[i] for i in side] for side in sides]
    return [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def tray():
    """A floor and four walls of 3 cm, 60 x 60 x 20 cm, open above."""
    return (
        block((-0.3, -0.3, 0.0), (0.3, 0.3, 0.03))
        + block((-0.3, -0.3, 0.03), (-0.27, 0.3, 0.2))
        + block((0.27, -0.3, 0.03), (0.3, 0.3, 0.2))
        + block((-0.27, -0.3, 0.03), (0.27, -0.27, 0.2))
        + block((-0.27, 0.27, 0.03), (0.27, 0.3, 0.2))
    )


def hills():
    """A heightmap: an image of 65 x 65 pixels, whose colors are three grounds."""

    def at(x, y):
        blue = 180 + 70 * math.sin(0.45 * x) * math.cos(0.35 * y)
        return 40 + x, 200 - y, round(blue), 100 + x

    rows = (b"\0" + bytes(v for x in range(65) for v in at(x, y)) for y in range(65))
    head = struct.pack(">IIBBBBB", 65, 65, 8, 6, 0, 0, 0)
    image = b"\x89PNG\r\n\x1a\n"
    for kind, data in ((b"IHDR", head), (b"IDAT", zlib.compress(b"".join(rows))), (b"IEND", b"")):
        image += struct.pack(">I", len(data)) + kind + data
        image += struct.pack(">I", zlib.crc32(kind + data))
    return image


def write_meshes(folder):
    """STL files of the meshes of robots, grounds and crates, and the image of a heightmap."""
    (folder / "hills.png").write_bytes(hills())
    meshes = {"wheel": wheel_triangles(), "waves": waves(), "tray": tray()}
    meshes["wedge"] = [
        [(x, y, z if x > 0 else 0.03) for x, y, z in corners]
        for corners in block((-0.1, -0.3, 0.0), (0.1, 0.3, 0.15))
    ]
    for name, triangles in meshes.items():
        with open(folder / f"{name}.stl", "wb") as file:
            file.write(bytes(80) + struct.pack("<I", len(triangles)))
            for triangle in triangles:
                numbers = [0.0, 0.0, 0.0, *(x for corner in triangle for x in corner)]
                file.write(struct.pack("<12fH", *numbers, 0))


SKID = {"mu1": 1.0, "mu2": 0.5, "fdir1": "1 0 0", "kp": 1e6, "kd": 10, "minDepth": 0.001}
SLIP = {"mu1": 0.8, "mu2": 0.6, "slip1": 0.02, "slip2": 0.05, "fdir1": "0 0 1"}
STEER = '<limit lower="-0.5" upper="0.5" effort="1000" velocity="30"/>'
SPRING = {"springStiffness": 800.0, "springReference": -0.02}
BALL, BLOCK = '<sphere radius="0.05"/>', '<box size="0.05 0.06 0.04"/>'
BUMPERS = (0.28, 0.1, -0.02), (0.28, -0.1, -0.02), (0.28, 0, 0.02)
ARM = '<limit lower="-1" upper="0.5" effort="10" velocity="3"/><dynamics friction="0.4"/>'
ARM_ON_A_POST = (
    link("base", 20.0, 2.0, '<box size="1 1 2"/>')
    + link("arm", 1.0, 0.01, center="0.3 0 0")
    + joint("hinge", "revolute", "base", "arm", more=ARM)
)
SENSOR = link("sensor", 0.1, 1e-4) + joint("held", "fixed", "base", "sensor", "0 0 0.1")
MESH = '<mesh filename="file://{folder}/wheel.stl"/>'

MESHES = "".join(wheel(name, *place, shape=MESH) for name, place in CORNERS.items())
SMALL = (
    link("base", 1.0, 0.005, '<box size="0.2 0.1 0.04"/>')
    + wheel("l", 0, 0.08, shape='<sphere radius="0.05"/>')
    + wheel("r", 0, -0.08, shape='<sphere radius="0.05"/>')
)

# name -> URDF, height at which it is spawned [m], commands (step, joint, 'velocity' of its motor,
# 'imposed' (a velocity that is set before each step), 'position', 'effort' or 'planar' (the model's
# velocity along x), value, the motor's effort, or the model's yaw rate)
KNEE = '<limit lower="-0.5" upper="0.5" effort="10" velocity="10"/>'
ROBOTS = {
    "a leg of four bars on wheels": (
        robot(
            BASE,
            *(wheel(name, x, y) for name, (x, y) in CORNERS.items()),
            link("thigh", 0.4, 0.002, center="0 0 0.1"),
            joint("hip", "continuous", "base", "thigh", "0.05 0 0.1"),
            link("foot", 0.8, 0.004, center="0.1 0 0.02"),
            joint("knee", "revolute", "thigh", "foot", "0 0 0.2", more=KNEE),
            link("bar", 0.3, 0.002, center="0 0 0.1"),
            joint("other", "continuous", "base", "bar", "0.35 0 0.1"),
            in_gazebo("ring", "revolute", "bar", "foot", "0.3 0 0"),
        ),
        0.12,
        ((100, "hip", "effort", 0.6, 0),),
    ),
    "sphere": (robot(link("base", 3.0, 0.02, '<sphere radius="0.2"/>')), 0.3, []),
    "box": (
        robot(link("base", 3.0, 0.02, '<box size="0.4 0.4 0.3"/>', center="0 0.02 0")),
        0.3,
        [],
    ),
    "standing cylinder": (
        robot(link("base", 3.0, 0.05, '<cylinder radius="0.2" length="0.5"/>')),
        0.3,
        [],
    ),
    "castor": (
        on_a_castor(0, link("ball", 0.2, 1e-4, BALL), -0.15, mu1=0.1, mu2=0.2),
        0.12,
        turn(("l", "r"), 3.0, 3.0) + turn(("l", "r"), -2.0, 2.0, at=400),
    ),
    "skid steering with fdir1, kp and kd": (
        robot(BASE, WHEELS, *(tags(name, maxVel=0.1, **SKID) for name in CORNERS)),
        0.12,
        turn(),
    ),
    "slip, which a URDF cannot give": (
        robot(BASE, WHEELS, *(tags(name, **SLIP) for name in CORNERS)),
        0.12,
        turn(),
    ),
    "spheres as wheels": (
        robot(
            BASE,
            *(wheel(n, *at, shape='<sphere radius="0.1"/>') for n, at in CORNERS.items()),
            *(tags(name, mu1=0.9, mu2=0.5) for name in CORNERS),
        ),
        0.12,
        turn(),
    ),
    "meshes as wheels": (
        robot(BASE, MESHES),
        0.12,
        turn(),
    ),
    "six wheels": (
        robot(BASE, WHEELS, wheel("ml", 0, 0.2), wheel("mr", 0, -0.2)),
        0.12,
        turn((*CORNERS, "ml", "mr")),
    ),
    "suspension": (robot(BASE, springs()), 0.12, turn()),
    "steering by effort": (
        robot(BASE, hinges(("fl", "fr"), STEER)),
        0.12,
        turn(left=5.0)
        + [(350, "sfl_joint", "effort", 0.5, 0.0), (350, "sfr_joint", "effort", 0.3, 0.0)],
    ),
    "parallel steering": (
        robot(BASE, hinges(("fl", "fr"), STEER)),
        0.12,
        turn(left=5.0)
        + [(step, name, "position", at, 0.0) for step, at in ((200, 0.0), (350, 0.3))
           for name in ("sfl_joint", "sfr_joint")],
    ),
    "imposed velocities": (
        robot(BASE, hinges(("fl", "fr"), STEER)),
        0.12,
        turn(left=5.0, kind="imposed")
        + [(step, name, "position", at, 0.0) for step, at in ((200, 0.0), (350, 0.3))
           for name in ("sfl_joint", "sfr_joint")],
    ),
    "limit and friction": (
        robot(ARM_ON_A_POST),
        1.0,
        [(200, "hinge", "effort", 4.0, 0.0), (400, "hinge", "effort", -4.0, 0.0)],
    ),
    "a rig on the world": (
        robot(
            '<link name="world"/>',
            joint("z_held", "fixed", "world", "base", "0.1 0 0.6"),
            BASE,
            link("arm", 3.0, 0.2, center="0.9 0 0.05"),
            joint("a_arm", "revolute", "base", "arm", "0.02 0.3 0.03", more=ARM),
            link("mast", 4.0, 0.2, center="0 0 0.7"),
            joint("m_mast", "continuous", "base", "mast", "0 0 0.1", axis="1 0 0"),
        ),
        0.5,
        [(0, "m_mast", "effort", 30.0, 0.0), (200, "a_arm", "effort", -20.0, 0.0)],
    ),
    "an arm on a merged plate": (
        robot(
            BASE,
            WHEELS,
            link("plate", 0.5, 0.01, '<box size="0.1 0.1 0.02"/>'),
            joint("g_mount", "fixed", "base", "plate", "0 0 0.1"),
            link("arm", 0.4, 2e-3, center="0.1 0 0.05"),
            joint("a_arm", "revolute", "plate", "arm", "0.02 0 0.03", more=ARM),
            tags("plate", maxVel=0.5, minDepth=0.001),
        ),
        0.12,
        turn(),
    ),
    "a castor whose collision has another name": (
        on_a_castor(
            0.15,
            link("ball", 0.2, 1e-3, BALL).replace("<collision>", '<collision name="foot">'),
            -0.2,
            mu1=0.05,
            mu2=0.05,
        ),
        0.12,
        turn(("l", "r"), 2.0, 4.0),
    ),
    "a castor with mu1 alone": (
        on_a_castor(0.15, link("ball", 0.2, 1e-3, BALL), -0.2, mu1=0.05),
        0.12,
        turn(("l", "r"), 2.0, 4.0),
    ),
    "two castors on one link": (
        robot(
            BASE,
            wheel("l", 0.15, 0.2),
            wheel("r", 0.15, -0.2),
            *on_the_base("ball", BALL, (-0.2, 0.1, -0.05), (-0.2, -0.1, -0.05)),
        ),
        0.12,
        turn(("l", "r"), 2.0, 4.0),
    ),
    "bumpers push blocks": with_bumpers(*BUMPERS),
    "two bumpers push blocks": with_bumpers(*BUMPERS[:2]),
    "bumpers into blocks": with_bumpers(*BUMPERS),
    "planar motion": (
        robot(BASE, WHEELS),
        0.12,
        [(200, "fl_joint", "planar", 0.5, 0.4), (400, "fl_joint", "planar", 0.0, 0.0)],
    ),
    "springs": (
        robot(BASE, springs(), *(tags(f"s{name}_joint", **SPRING) for name in CORNERS)),
        0.12,
        turn(),
    ),
    "implicit springs": (
        robot(
            BASE,
            springs(),
            *(tags(f"s{name}_joint", implicitSpringDamper=1, **SPRING) for name in CORNERS),
        ),
        0.12,
        turn(),
    ),
    "soft limit": (
        robot(ARM_ON_A_POST, tags("hinge", stopErp=0.05, stopCfm=0.02, fudgeFactor=0.4)),
        1.0,
        [(30, "hinge", "velocity", 3.0, 4.0), (260, "hinge", "velocity", -1.0, 8.0)],
    ),
    "velocities that decay": (
        robot(
            BASE,
            WHEELS,
            SENSOR,
            tags("fl", dampingFactor=0.01),
            tags("base", dampingFactor=0.004),
            tags("sensor", dampingFactor=0.002),
        ),
        0.12,
        turn(),
    ),
    "a merged link without gravity": (
        robot(
            BASE,
            WHEELS,
            SENSOR,
            tags("sensor", turnGravityOff="true"),
        ),
        0.12,
        turn(),
    ),
}  # fmt: skip
ROBOTS.update({
    "efforts beyond a continuous joint's limits": (
        robot(BASE, WHEELS.replace("</joint>", f"{WEAK}</joint>")),
        0.12,
        [(200, f"{name}_joint", "effort", 0.9 if name[-1] == "l" else 0.6, 0.0)
         for name in CORNERS],
    ),
    "wheels push a crate": (robot(BASE, WHEELS), 0.12, turn(left=5.0)),
    "wheels over a plank": (robot(BASE, WHEELS), 0.12, turn(left=5.0)),
    "spheres push a crate": (robot(BASE, BALLS), 0.12, turn(left=5.0)),
    "wheels push a can": (robot(BASE, WHEELS), 0.12, turn(left=5.0, at=330)),
    "wheels against a post": (robot(BASE, WHEELS), 0.12, turn(left=5.0)),
    "spheres push a can": (robot(BASE, BALLS), 0.12, turn(left=5.0, at=330)),
    "spheres against a ball": (robot(BASE, BALLS), 0.12, turn(left=5.0)),
    "a chassis against a post": (robot(BASE, WHEELS), 0.12, turn(left=5.0)),
    "one link that collides with its model": (robot(BASE, WHEELS, ARM_ON_BASE), 0.12, []),
    "a tilted box falls on a crate": (robot(TILTED), 0.4, []),
    "a tilted box on a box": (robot(TILTED), 0.12, []),
    "cylinders on a mesh": (robot(BASE, WHEELS), 0.12, turn()),
    "spheres on a mesh": (robot(BASE, BALLS), 0.12, turn()),
    "meshes on a mesh": (robot(BASE, MESHES), 0.12, turn()),
    "a tilted box on a mesh": (robot(TILTED), 0.12, []),
    "meshes on a box": (robot(BASE, MESHES), 0.12, turn()),
    "meshes push a crate": (robot(BASE, MESHES), 0.12, turn(left=5.0)),
    "meshes push a can": (robot(BASE, MESHES), 0.12, turn(left=5.0, at=330)),
    "meshes against a ball": (robot(BASE, MESHES), 0.12, turn(left=5.0)),
    "meshes against a post": (robot(BASE, MESHES), 0.12, turn(left=5.0)),
    "meshes against a wedge": (robot(BASE, MESHES), 0.12, turn(left=5.0)),
    "wheels against a wedge": (robot(BASE, WHEELS), 0.12, turn(left=5.0)),
    "a tilted box in a tray": (robot(TILTED), 0.3, []),
    "a car in a tray": (robot(SMALL), 0.12, turn(("l", "r"), 3.0, 4.0)),
    "a mesh in a tray": (robot(link("base", 1.0, 0.01, MESH)), 0.25, []),
})  # fmt: skip


def surface(bounce="", friction="", contact=""):
    """<surface> of SDF; in a URDF it is in <collision> of a <gazebo> element."""
    parts = ("bounce", bounce), ("friction", friction), ("contact", contact)
    inner = "".join(f"<{key}>{text}</{key}>" for key, text in parts if text)
    return f"<surface>{inner}</surface>"


def torsional(coefficient, **values):
    """<torsional> of <friction>."""
    inner = "".join(f"<{key}>{value}</{key}>" for key, value in values.items())
    return f"<torsional><coefficient>{coefficient}</coefficient>{inner}</torsional>"


BOUNCE = (
    "<restitution_coefficient>0.6</restitution_coefficient><threshold>0.1</threshold>",
    "",
    "<ode><max_vel>100</max_vel></ode>",
)
SMALL_PATCH, LARGE_PATCH = torsional(0.8, patch_radius=0.05), torsional(1.0, patch_radius=0.08)
ROUND = torsional(0.8, use_patch_radius=0, surface_radius=0.1)
TWIST = torsional(0.8, patch_radius=0.05, ode="<slip>2</slip>")


def twisting(friction):
    """A base on four balls with torsional friction."""
    own = (tags(name, collision=surface(friction=friction)) for name in CORNERS)
    return robot(BASE, BALLS, *own), 0.12, turn()


# name -> <surface> of the ground, where it is another one
GROUNDS = {
    "a ball that bounces": surface(*BOUNCE),
    "balls that twist": surface(friction=LARGE_PATCH),
    "balls that twist by their depth": surface(friction=ROUND),
    "balls that twist and slip": surface(friction=TWIST),
}
NARROW = '<cylinder radius="0.1" length="0.002"/>'
ROBOTS.update({
    "a ball that bounces": (
        robot(
            link("base", 3.0, 0.02, '<sphere radius="0.2"/>'),
            tags("base", collision=surface(*BOUNCE)),
        ),
        0.3,
        [],
    ),
    "a decay that does not count": (
        robot(
            link("base", 3.0, 0.02, '<sphere radius="0.2"/>'),
            tags("base", gravity="false", velocity_decay="<linear>0.01</linear>"),
        ),
        0.3,
        [],
    ),
    "balls that twist": twisting(SMALL_PATCH),
    "balls that twist by their depth": twisting(ROUND),
    "balls that twist and slip": twisting(TWIST),
    "a box on two contacts": (
        robot(
            link("base", 3.0, 0.02, '<box size="0.4 0.4 0.3"/>'), tags("base", maxContacts=2)
        ),
        0.2,
        [],
    ),
    "wheels on one contact each": (
        robot(BASE, WHEELS, *(tags(name, maxContacts=1) for name in CORNERS)), 0.12, turn(),
    ),
    "narrow wheels and a castor": (
        on_a_castor(0, link("ball", 0.2, 1e-4, BALL), -0.15, mu1=0.1, mu2=0.1).replace(
            '<cylinder radius="0.1" length="0.05"/>', NARROW
        ),
        0.12,
        turn(("l", "r"), 3.0, 3.0) + turn(("l", "r"), 0.0, 0.0, at=300),
    ),
    "a slider pushed against its stop": (
        robot(
            BASE,
            WHEELS,
            link("lift", 1.0, 0.01, center="0.05 0 0.1"),
            joint("mast", "prismatic", "base", "lift", "-0.2 0.05 0.1", "0 0 1",
                  more='<limit lower="0" upper="0.1" effort="500" velocity="1"/>'),
        ),
        0.12,
        [(200, "mast", "velocity", 0.0, 60.0)],
    ),
    "two wheels between two castors": (
        robot(
            BASE,
            wheel("l", 0, 0.15),
            wheel("r", 0, -0.15),
            *on_the_base("ball", BALL, (-0.15, 0, -0.05), (0.15, 0, -0.05)),
        ),
        0.12,
        turn(("l", "r"), 5.0, 5.0),
    ),
})  # fmt: skip
# a base with balls below it and blocks in front, so that one link touches ground and blocks
SLED = (
    BASE,
    wheel("l", 0, 0.2),
    wheel("r", 0, -0.2),
    *on_the_base("ball", BALL, *((x, y, -0.05) for x in (-0.15, 0.15) for y in (-0.1, 0.1))),
)
SLED_WITH_BUMPERS = robot(*SLED, *on_the_base("bumper", BLOCK, *BUMPERS))
ROBOTS.update({
    "five shapes on one link": (robot(*SLED), 0.0995, turn(("l", "r"), 3.0, 4.0)),
    "a sled against blocks": (SLED_WITH_BUMPERS, 0.0995, turn(("l", "r"), 4.0, 4.0)),
    "a sled pushes blocks": (SLED_WITH_BUMPERS, 0.0995, turn(("l", "r"), 4.0, 4.0)),
})  # fmt: skip
ROBOTS.update({
    "a kinematic base": (
        robot(BASE, WHEELS, tags("base", kinematic="true")),
        0.12,
        [(100, "fl_joint", "planar", 0.5, 0.4), (300, "fl_joint", "planar", 0.0, 0.0)],
    ),
    "an arm on a kinematic base": (
        robot(
            link("base", 2.0, 0.01, '<box size="0.2 0.2 0.1"/>'),
            link("arm", 1.0, 0.01, center="0.2 0 0"),
            joint("hinge", "revolute", "base", "arm", more=ARM),
            tags("base", kinematic="true"),
        ),
        0.5,
        [(200, "hinge", "effort", 4.0, 0.0)],
    ),
})  # fmt: skip
CRATE, CAN = "<box><size>0.2 0.5 0.2</size></box>", "<radius>0.1</radius><length>0.2</length>"
CAN, POST = f"<cylinder>{CAN}</cylinder>", "<radius>0.05</radius><length>0.5</length>"
POST = f"<cylinder>{POST}</cylinder>"
BLOCKS = (  # several shapes of one link, each at a place
    ("0 0 0", "<box><size>0.1 0.4 0.05</size></box>"),
    ("0.01 0.15 0.1", "<box><size>0.1 0.1 0.15</size></box>"),
    ("0 0 -0.06", "<sphere><radius>0.04</radius></sphere>"),
)
# of others in front of the robot: place [m] and yaw [rad], shape, mass [kg] (0: it never moves),
# (ixx, iyy, izz)
CRATES = {
    "bumpers push blocks": ((0.4, 0.02, 0.1), BLOCKS, 2.0, (0.05, 0.02, 0.06)),
    "two bumpers push blocks": ((0.4, 0.02, 0.1), BLOCKS, 2.0, (0.05, 0.02, 0.06)),
    "bumpers into blocks": ((0.4, 0.02, 0.1), BLOCKS, 0.0, ()),
    "a sled against blocks": ((0.36, 0.02, 0.1), BLOCKS, 0.0, ()),
    "a sled against blocks on a box": ((0.36, 0.02, 0.1), BLOCKS, 0.0, ()),
    "a sled pushes blocks": ((0.36, 0.02, 0.1), BLOCKS, 2.0, (0.05, 0.02, 0.06)),
    "wheels push a crate": ((0.43, 0.02, 0.1), CRATE, 2.0, (0.05, 0.02, 0.06)),
    "spheres push a crate": ((0.43, 0.02, 0.1), CRATE, 2.0, (0.05, 0.02, 0.06)),
    "wheels over a plank": (
        (0.37, 0.0, 0.01), "<box><size>0.1 1 0.02</size></box>", 1.0, (0.08, 0.001, 0.08)
    ),
    "a tilted box falls on a crate": (
        (0.1, 0.05, 0.1), "<box><size>0.4 0.4 0.2</size></box>", 2.0, (0.04, 0.04, 0.06)
    ),
    "wheels push a can": ((0.42, 0.2, 0.1), CAN, 1.0, (0.006, 0.006, 0.005)),
    "wheels against a post": ((0.37, -0.2, 0.25), POST, 0.0, ()),
    "spheres push a can": ((0.43, 0.21, 0.1), CAN, 1.0, (0.006, 0.006, 0.005)),
    "spheres against a ball": (
        (0.43, -0.19, 0.08), "<sphere><radius>0.08</radius></sphere>", 0.5, (0.001, 0.001, 0.001)
    ),
    "a chassis against a post": ((0.3, 0.02, 0.25), POST, 0.0, ()),
    "meshes push a crate": ((0.45, 0.02, 0.1, 0.1), CRATE, 2.0, (0.05, 0.02, 0.06)),
    "meshes push a can": ((0.42, 0.2, 0.1), CAN, 1.0, (0.006, 0.006, 0.005)),
    "meshes against a ball": (
        (0.43, -0.19, 0.08), "<sphere><radius>0.08</radius></sphere>", 0.5, (0.001, 0.001, 0.001)
    ),
    "meshes against a post": ((0.37, -0.2, 0.25), POST, 0.0, ()),
    "meshes against a wedge": ((0.45, 0.02, 0.0, 0.1), "wedge", 2.0, (0.05, 0.02, 0.06)),
    "wheels against a wedge": ((0.45, 0.02, 0.0, 0.1), "wedge", 0.0, ()),
    "a tilted box in a tray": ((0.1, 0.05, 0.0, 0.1), "tray", 3.0, (0.1, 0.1, 0.2)),
    "a car in a tray": ((0.02, 0.01, 0.0, 0.1), "tray", 3.0, (0.1, 0.1, 0.2)),
    "a mesh in a tray": ((0.02, 0.2, 0.0, 0.1), "tray", 3.0, (0.1, 0.1, 0.2)),
}  # fmt: skip
BOX = "40 40 1"  # [m] size of the ground of some of them, instead of a plane; its top is at 0
ON_A_BOX, ON_A_MESH, ON_HILLS = " on a box", " on a mesh", " on hills"  # end their names
for _name in (
    "sphere",
    "skid steering with fdir1, kp and kd",
    "spheres as wheels",
    "suspension",
    "parallel steering",
    "a merged link without gravity",
    "two castors on one link",
    "five shapes on one link",
    "a sled against blocks",
):
    ROBOTS[_name + ON_A_BOX] = ROBOTS[_name]
for _name in (
    "sphere",
    "skid steering with fdir1, kp and kd",
    "spheres as wheels",
    "suspension",
    "five shapes on one link",
    "meshes as wheels",
):
    ROBOTS[_name + ON_HILLS] = ROBOTS[_name]
SHOCK = '<limit lower="-0.05" upper="0.05" effort="1000" velocity="10"/><dynamics damping="50"/>'
CHASSIS = link("base", 12.0, (0.3, 0.5, 0.6), '<box size="0.7 0.4 0.1"/>', center="0 0 0.15")


def on_shocks(**spring):
    """A heavy base whose wheels are on sliders that reach their stops."""
    parts = [CHASSIS]
    for name, (x, y) in CORNERS.items():
        slider = joint(
            f"s{name}", "prismatic", "base", f"{name}_s", f"{x} {y} -0.05", "0 0 1", SHOCK
        )
        parts += [link(f"{name}_s", 0.5, 1e-3), slider, wheel(name, 0, 0, f"{name}_s")]
        parts.append(tags(f"s{name}", springStiffness=2000.0, springReference=0.0, **spring))
    return robot(*parts)


def on_swivels(*places):
    """Castors of a swivel and a roller each, at x and y."""
    parts, roller = [], '<cylinder radius="0.05" length="0.03"/>'
    for i, (x, y) in enumerate(places):
        swivel = joint(f"swivel{i}", "continuous", "base", f"fork{i}", f"{x} {y} -0.02", "0 0 1")
        roll = joint(f"roll{i}", "continuous", f"fork{i}", f"castor{i}", "-0.04 0 -0.03")
        parts += [link(f"fork{i}", 0.2, 2e-4), swivel, roll]
        parts.append(link(f"castor{i}", 0.3, 4e-4, roller, "1.5707963 0 0"))
    return parts


TALL = link("base", 10.0, (1.0, 1.0, 0.1), '<box size="0.25 0.2 0.9"/>', center="0 0 0.45")
TALL = TALL.replace("<collision><origin", '<collision><origin xyz="0 0 0.5"', 1)
LIGHT = "".join(wheel(name, *place) for name, place in CORNERS.items()).replace(
    '<mass value="0.5"/>', '<mass value="0.05"/>'
)
SPIN = [(0, "left_joint", "velocity", -2.0, 30.0), (0, "right_joint", "velocity", 2.0, 30.0)]
TWO_WHEELS = wheel("left", 0.15, 0.25) + wheel("right", 0.15, -0.25)
ROBOTS.update({
    "a truck on shocks": (on_shocks(), 0.25, turn()),
    "a truck on shocks with implicit dampers": (on_shocks(implicitSpringDamper=1), 0.25, turn()),
    "two castors behind turn on the spot": (
        robot(CHASSIS, TWO_WHEELS, *on_swivels((-0.25, 0.15), (-0.25, -0.15))), 0.12, SPIN,
    ),
    "a castor in front turns on the spot": (
        robot(CHASSIS, TWO_WHEELS.replace('xyz="0.15', 'xyz="-0.15'), *on_swivels((0.25, 0))),
        0.12,
        SPIN,
    ),
    "a tall base on light wheels": (robot(TALL, LIGHT), 0.12, turn(left=1.0, right=6.0, at=100)),
})  # fmt: skip
ROBOTS["a tilted box" + ON_HILLS] = ROBOTS["a tilted box" + ON_A_MESH]


def ground(name):
    """SDF of a robot's ground."""
    shape, height = "<plane><normal>0 0 1</normal><size>100 100</size></plane>", 0.0
    if name.endswith(ON_A_BOX):
        shape, height = f"<box><size>{BOX}</size></box>", -0.5
    elif name.endswith(ON_A_MESH):
        shape = "<mesh><uri>file://{folder}/waves.stl</uri></mesh>"
    elif name.endswith(ON_HILLS):
        shape = (
            "<heightmap><uri>file://{folder}/hills.png</uri><size>8 8 0.08</size>"
            "<pos>0.5 -0.3 -0.08</pos></heightmap>"
        )
    rough = surface(friction="<ode><mu>100</mu><mu2>50</mu2></ode>")
    return (
        f'<model name="ground_plane"><static>1</static><pose>0 0 {height} 0 0 0</pose>'
        f'<link name="link"><collision name="collision"><geometry>{shape}</geometry>'
        f"{GROUNDS.get(name, rough)}</collision></link></model>"
    )


def crate(name):
    """SDF of what is in front of a robot, or ''."""
    if name not in CRATES:
        return ""
    place, shape, mass, moments = CRATES[name]
    x, y, z, yaw = (*place, 0)[:4]
    inertia = "".join(f"<i{2 * axis}>{value}</i{2 * axis}>" for axis, value in zip("xyz", moments))
    if isinstance(shape, str) and "<" not in shape:
        shape = f"<mesh><uri>file://{{folder}}/{shape}.stl</uri></mesh>"
    inertial = f"<inertial><mass>{mass}</mass><inertia>{inertia}</inertia></inertial>"
    collisions = "".join(
        f'<collision name="collision{i or ""}"><pose>{at} 0 0 0</pose><geometry>{each}</geometry>'
        "</collision>"
        for i, (at, each) in enumerate([("0 0 0", shape)] if isinstance(shape, str) else shape)
    )
    return (
        f'<model name="crate"><static>{int(not mass)}</static>'
        "<allow_auto_disable>0</allow_auto_disable>"
        f'<pose>{x} {y} {z} 0 0 {yaw}</pose><link name="crate">'
        f"{inertial if mass else ''}{collisions}</link></model>"
    )


def body(name, at, shape, mass=1.0, inertia=0.01, center="0 0 0"):
    """A link of an SDF at a place (x y z roll pitch yaw)."""
    collision = f'<collision name="c"><geometry>{shape}</geometry></collision>' if shape else ""
    moments = "".join(f"<{axis}>{inertia}</{axis}>" for axis in ("ixx", "iyy", "izz"))
    return (
        f'<link name="{name}"><pose>{at}</pose><inertial><pose>{center} 0 0 0</pose>'
        f"<mass>{mass}</mass><inertia>{moments}</inertia></inertial>{collision}</link>"
    )


def connected(name, kind, parent, child, more="<xyz>0 1 0</xyz>", rest=""):
    """A joint of an SDF."""
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"<axis>{more}</axis>{rest}</joint>"
    )


CUBE, BEAM = "<box><size>0.2 0.2 0.2</size></box>", "<box><size>0.4 0.1 0.1</size></box>"
BALL = "<sphere><radius>0.1</radius></sphere>"
POST = body("post", "0 0 1 0 0 0", "", 5.0, 0.1) + connected("held", "fixed", "world", "post")
ODE = "<physics><ode>{}</ode></physics>"
ROLLER = "<cylinder><radius>0.1</radius><length>0.04</length></cylinder>"
LONG_ARMS = (
    body("base", "0 0 1 0 0 0", CUBE, 2.0)
    + body("left", "0 0.8 1 0 0 0", "", 4.0, 0.2, "0 0.4 0")
    + body("right", "0.5 0 1.1 0 0 0", "", 6.0, 0.3, "0.9 0 0.1")
    + body("tip", "2 0 1.2 0 0 0", "", 3.0, 0.1, "0.3 0 0")
    + connected("left_joint", "revolute", "base", "left", "<xyz>1 0 0</xyz>")
    + connected("right_joint", "revolute", "base", "right", "<xyz>0 0 1</xyz>")
    + connected("tip_joint", "revolute", "right", "tip")
)
LOW = "<limit><lower>-0.3</lower><upper>0.2</upper></limit>"


def screw(pitch):
    """A nut that falls on its thread, with another one on it."""
    thread = f"<thread_pitch>{pitch}</thread_pitch>"
    return (
        POST
        + body("nut", "0.01 0.02 2.6 0 0 0.3", "", 1.0, center="0.05 0 0.01")
        + body("arm", "0.1 0.02 2.6 0 0 0.3", "", 0.5, center="0.05 0 0.01")
        + connected("screw", "screw", "post", "nut", "<xyz>0 0 1</xyz>", thread)
        + connected("screw2", "screw", "nut", "arm", "<xyz>0 1 0</xyz>", thread)
    )


def gears(ratio):
    """Two wheels on a base, of which the first is turned by an effort."""
    axes = "<axis><xyz>0 1 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    return (
        body("base", "0 0 0.1 0 0 0", CUBE, 5.0, 0.05)
        + body("one", "0.3 0.2 0.4 0 0 0", "", 0.5)
        + body("two", "-0.3 0.2 0.4 0 0 0", "", 1.0, 0.02)
        + connected("one_joint", "revolute", "base", "one")
        + connected("two_joint", "revolute", "base", "two")
        + f'<joint name="gears" type="gearbox"><parent>two</parent><child>one</child>{axes}'
        f"<gearbox_ratio>{ratio}</gearbox_ratio>"
        "<gearbox_reference_body>base</gearbox_reference_body></joint>"
    )


def swinging(ode, kind="revolute", axis="<xyz>0 1 0</xyz>" + LOW):
    """An arm on a post, with parameters of its joint for ODE."""
    return (
        POST
        + body("arm", "0 0.2 1 0 0 0", "", center="0.2 0 0.1")
        + body("tip", "0.4 0.2 1 0 0 0", "", 0.5)
        + connected("elbow", kind, "post", "arm", axis, ODE.format(ode))
        + connected("wrist", "revolute", "arm", "tip", rest=ODE.format(ode))
    )


def bouncing(kind, axis):
    """An arm on a post that bounces at its limits."""
    rest = ODE.format("<bounce>0.5</bounce>")
    arm = body("arm", "0 0.2 1 0 0 0", "", center="0.2 0 0.1")
    return POST + arm + connected("elbow", kind, "post", "arm", f"<xyz>{axis}</xyz>{LOW}", rest)


def pinned(name, parent, child, at, kind="revolute", more="<xyz>0 1 0</xyz>"):
    """A joint at a place in its child's frame."""
    return connected(name, kind, parent, child, more, f"<pose>{at} 0 0 0</pose>")


def four_bars(base, last):
    """Four links in a ring.

    Args:
        base: of which the post is held, or not.
        last: the joint that closes the ring.
    """
    return (
        base
        + body("crank", "0 0.1 1 0 0 0", "", 0.4, 0.002, "0 0 0.1")
        + body("coupler", "0 0.1 1.2 0 0.1 0", "", 0.6, 0.004, "0.2 0 0.02")
        + body("rocker", "0.5 0.1 0.9 0 0.2 0", "", 0.5, 0.003, "0 0 0.1")
        + connected("low", "revolute", "post", "crank")
        + connected("high", "revolute", "crank", "coupler", "<xyz>0 1 0</xyz><dynamics/>")
        + connected("other", "revolute", "post", "rocker")
        + last
    )


RING = pinned("ring", "rocker", "coupler", "0.5 0 0.05")
FREE = body("post", "0 0 1 0 0 0", "", 5.0, 0.1)
CRANK_AND_SLIDER = (
    POST
    + body("crank", "0 0.1 1 0 0 0", "", 0.4, 0.002, "0 0 0.1")
    + body("rod", "0 0.1 1.2 0 0.35 0", "", 0.3, 0.003, "0.25 0 0")
    + body("slider", "0.47 0.1 1.03 0 0 0.2", "", 0.8, 0.004, "0.01 0 0")
    + connected("low", "revolute", "post", "crank")
    + connected("high", "revolute", "crank", "rod")
    + connected("end", "revolute", "rod", "slider", "<xyz expressed_in='__model__'>0 1 0</xyz>")
)
LIMITED = (
    "<limit><lower>-0.05</lower><upper>0.04</upper></limit>"
    "<dynamics><damping>2</damping></dynamics>"
)

# Models of SDF, of which the record has all links: their text, commands as those of ROBOTS.
MODELS = {
    "links without joints": (
        body("a", "0 0 0.3 0.3 0.2 0.1", CUBE)
        + body("b", "0.6 0 0.4 0 0 0.5", BALL, center="0.02 0 0.01")
        + body("c", "-0.8 0 0.6 0.1 0.05 0.4", BEAM)
        + body("d", "-0.8 0.3 0.6 0.2 0 0", BEAM, 0.5, center="0.1 0 0")
        + body("e", "0 1 0.2 0.4 0.3 0.2", CUBE, 2.0)
        + connected("swing", "revolute", "c", "d", "<xyz>0 1 0</xyz><dynamics/>"),
        (),
    ),
    "a pile of links": (
        "<self_collide>1</self_collide>"
        + body("a", "0 0 0.101 0 0 0", CUBE)
        + body("b", "0.03 0.01 0.302 0 0 0.2", CUBE)
        + body("c", "0 -0.02 0.52 0 0 0.4", BALL),
        (),
    ),
    "links without joints beside one that is held": (
        body("post", "0 0 1 0 0 0", CUBE)
        + body("arm", "0 0.2 1 0 0 0", BEAM, center="0.1 0 0")
        + body("ball", "0.5 0 0.5 0 0 0", BALL)
        + connected("held", "fixed", "world", "post")
        + connected("elbow", "revolute", "post", "arm"),
        (),
    ),
    "a screw": (screw(20), ((100, "screw", "effort", 0.4, 0),)),
    "a screw of a small pitch": (screw(0.5), ()),
    "gears": (gears(2), ((0, "one_joint", "effort", 0.3, 0),)),
    "gears that turn alike": (gears(-0.5), ((0, "two_joint", "effort", 0.3, 0),)),
    "erp and cfm of joints": (swinging("<erp>0.02</erp><cfm>0.001</cfm>"), ()),
    "bounce of a hinge": (bouncing("revolute", "0 1 0"), ()),
    "bounce of a slider": (bouncing("prismatic", "0 0 -1"), ()),
    "no bounce at a lower limit": (bouncing("prismatic", "0 0 1"), ()),
    "motors of joints": (swinging("<max_force>3</max_force><velocity>-0.5</velocity>"), ()),
    "motors beyond the largest velocity of a correction": (
        POST
        + body("one", "0 0.5 1 0 0 0", "", 0.5)
        + body("two", "0 -0.5 1 0 0 0", "", 0.5, center="0.02 0 0")
        + connected("one_joint", "revolute", "post", "one")
        + connected("two_joint", "revolute", "post", "two"),
        ((50, "one_joint", "velocity", 150.0, 50.0), (50, "two_joint", "velocity", -150.0, 50.0)),
    ),
    "four bars": (four_bars(POST, RING), ()),
    "four bars, put to a position": (four_bars(POST, RING), ((100, "low", "position", 0.2, 0),)),
    "four bars that fall, pushed": (four_bars(FREE, RING), ((0, "low", "effort", 0.5, 0),)),
    "four bars that end at the root": (
        four_bars(POST, pinned("ring", "coupler", "rocker", "0.01 0 0.25")),
        ((100, "ring", "effort", 0.2, 0),),
    ),
    "a ring that is closed before its links hang": (
        RING.replace('name="ring"', 'name="first"') + four_bars(POST, ""),
        (),
    ),
    "a crank and a slider of the world": (
        CRANK_AND_SLIDER
        + connected("guide", "prismatic", "world", "slider", f"<xyz>1 0 0</xyz>{LIMITED}"),
        (),
    ),
    "a crank and a slider of the post": (
        CRANK_AND_SLIDER
        + connected("guide", "prismatic", "slider", "post", f"<xyz>1 0 0</xyz>{LIMITED}"),
        (),
    ),
    "two arms and a fixed joint": (
        POST
        + body("one", "0 0.1 1 0 0 0", "", 0.4, 0.002, "0.1 0 0")
        + body("two", "0.4 0.1 1 0 0 0.3", "", 0.6, 0.004, "-0.1 0 0.02")
        + connected("left", "revolute", "post", "one")
        + connected("right", "revolute", "post", "two", "<xyz>0 0 1</xyz>")
        + connected("weld", "fixed", "one", "two"),
        (),
    ),
    "what hangs is fixed to the world": (
        body("a", "0 0 1 0 0 0", "", 1.0, center="0.1 0 0")
        + body("b", "0 0.2 1 0 0 0.3", "", 0.6, 0.004, "-0.1 0 0.02")
        + connected("elbow", "revolute", "a", "b")
        + connected("held", "fixed", "world", "b"),
        (),
    ),
    "arms on a base that is held": (
        LONG_ARMS + connected("held", "fixed", "world", "base"),
        ((0, "left_joint", "effort", 60.0, 0), (250, "right_joint", "effort", -40.0, 0)),
    ),
    "a base that is held first, and turned": (
        connected("held", "fixed", "world", "base")
        + LONG_ARMS.replace('"base"><pose>0 0 1 0 0 0', '"base"><pose>0 0 1 0.2 0.1 0.4'),
        ((0, "left_joint", "effort", 60.0, 0),),
    ),
    "two links that are held, one with an arm of the world": (
        body("one", "0 0 1 0 0 0.2", CUBE, center="0.02 0 0.01")
        + body("two", "1 0 1 0.3 0 0", CUBE, 2.0)
        + body("arm", "0 1 1 0 0 0", BEAM, 3.0, center="0.2 0 0")
        + body("tip", "0.5 1 1 0 0 0", BEAM, 1.0, center="0.1 0 0")
        + connected("first", "fixed", "world", "one")
        + connected("shoulder", "revolute", "world", "arm")
        + connected("elbow", "revolute", "arm", "tip")
        + connected("second", "fixed", "world", "two"),
        (),
    ),
    "links on fixed joints": (
        body("base", "0 0 0.12 0 0 0", BEAM, 5.0, 0.05)
        + body("head", "0.1 0 0.72 0 0 0.3", BALL, 2.0, 0.02)
        + body("mast", "0.1 0 0.42 0 0 0", "<box><size>0.05 0.05 0.4</size></box>", 0.5)
        + body("left", "0 0.2 0.12 -1.5707963 0 0", ROLLER, 0.5, 0.002)
        + body("right", "0 -0.2 0.12 -1.5707963 0 0", ROLLER, 0.5, 0.002)
        + connected("left_joint", "revolute", "base", "left", "<xyz>0 0 1</xyz>")
        + connected("neck", "fixed", "mast", "head")
        + connected("right_joint", "revolute", "base", "right", "<xyz>0 0 1</xyz>")
        + connected("foot", "fixed", "base", "mast"),
        ((100, "left_joint", "velocity", 4.0, 5.0), (100, "right_joint", "velocity", 2.0, 5.0)),
    ),
    "a chain of fixed joints": (
        body("a", "0 0 0.5 0.2 0.1 0.1", BEAM, 0.5)
        + body("b", "0.4 0 0.5 0.3 0.1 0.1", BEAM, 4.0, 0.05)
        + body("c", "0.8 0 0.5 0.1 0.2 0", BEAM, 0.3)
        + body("d", "1.2 0 0.5 0.4 0.1 0", BEAM, 6.0, 0.08)
        + connected("cd", "fixed", "c", "d")
        + connected("ab", "fixed", "a", "b")
        + connected("bc", "fixed", "b", "c"),
        (),
    ),
    "suspension of joints": (
        swinging("<suspension><erp>0.01</erp><cfm>0.1</cfm></suspension>"),
        (),
    ),
}


PIDS = (
    "<pos_pid><p>3000</p><i>200</i><d>100</d><i_max>5</i_max><i_min>-5</i_min>"
    "<cmd_max>400</cmd_max><cmd_min>-400</cmd_min></pos_pid>"
    "<vel_pid><p>500</p><d>0.5</d><cmd_max>300</cmd_max></vel_pid>"
)
LOWERED = (
    (100, "bot", "winch", -0.3, 0),
    (250, "bot", "winch", 0.0, 0),
    (400, "bot", "detach", 0, 0),
)


def harness(*joints, winch="winch", pids=PIDS):
    """Gazebo's HarnessPlugin; joints: (name, type, parent, child, pose, elements of the axis)."""
    made = "".join(
        f'<joint name="{name}" type="{kind}"><pose>{pose}</pose><parent>{parent}</parent>'
        f"<child>{child}</child><axis>{axis}</axis></joint>"
        for name, kind, parent, child, pose, axis in joints
    )
    return (
        f'<plugin name="harness" filename="libHarnessPlugin.so">{made}<winch><joint>{winch}'
        f"</joint>{pids}</winch><detach>{winch}</detach></plugin>"
    )


def axis(limit="", xyz="0 0 1", more=""):
    """Elements of an <axis>."""
    return f"<xyz>{xyz}</xyz>{more}" + (limit and f"<limit>{limit}</limit>")


EFFORT = "<effort>1000</effort><velocity>10</velocity>"
LOWERABLE = f"<lower>-0.5</lower><upper>0.02</upper>{EFFORT}"
LOW_ALONE = "<lower>-0.5</lower><upper>0</upper>"
BOX = body("box", "0 0 1.5 0 0 0", CUBE, 5.0, 0.05)
ARM = (
    body("base", "0 0 1 0.2 0.1 0.3", CUBE, 5.0, 0.05)
    + body("arm", "0.3 0 1.2 0 0.2 0.1", BEAM, 1.0, center="0.1 0 0")
    + connected("swing", "revolute", "base", "arm")
)

# Models that a HarnessPlugin holds.
HARNESSES = {
    "a harness": (
        BOX + harness(("winch", "prismatic", "world", "box", "0 0 0 0 0 0", axis(LOWERABLE))),
        LOWERED,
    ),
    "a harness without an effort": (
        BOX + harness(("winch", "prismatic", "world", "box", "0 0 0 0 0 0", axis(LOW_ALONE))),
        LOWERED,
    ),
    "a harness that is turned": (
        ARM
        + harness(
            (
                *("winch", "prismatic", "world", "arm", "0.1 0 0.05 0.1 0.2 0.3"),
                axis(LOWERABLE, "0 0.1 1", "<dynamics><damping>5</damping></dynamics>"),
            )
        ),
        LOWERED,
    ),
    "a harness by a hinge": (
        ARM
        + harness(
            ("held", "fixed", "world", "base", "0 0 0 0 0 0", axis()),
            ("winch", "revolute", "world", "arm", "0 0 0.1 0 0 0.2", axis(xyz="0 1 0")),
        ),
        LOWERED,
    ),
    "a harness with a spring": (
        BOX
        + harness(
            (
                *("winch", "prismatic", "world", "box", "0 0 0 0 0 0"),
                axis(
                    more="<dynamics><damping>2</damping><friction>3</friction><spring_reference>"
                    "-0.1</spring_reference><spring_stiffness>200</spring_stiffness></dynamics>"
                ),
            )
        ),
        LOWERED,
    ),
    "a harness of two joints": (
        ARM
        + harness(
            (
                *("winch", "prismatic", "world", "arm", "0 0 0 0.3 0.2 0"),
                axis(LOWERABLE, "0 0 1", "<use_parent_model_frame>1</use_parent_model_frame>"),
            ),
            ("second", "revolute", "base", "tip", "0 0 0 0 0 0", axis(xyz="1 0 0")),
        )
        + body("tip", "-0.4 0 1.2 0 0.2 0.1", BALL, 0.5),
        LOWERED,
    ),
}

WINDY = "<enable_wind>1</enable_wind>"
SWINGING = (
    body("a", "0 0 3 0 0 0.5", CUBE, 2.0, center="0.02 0 0.01")
    + body("arm", "0.3 0 3.2 0 0.2 0.1", BEAM, 1.0, center="0.2 0 0")
    + body("b", "0 2 3 0 0 0", CUBE)
    + connected("swing", "revolute", "a", "arm")
)
GUSTS = (
    "<horizontal><magnitude><time_for_rise>0.5</time_for_rise><sin><amplitude_percent>0.3"
    "</amplitude_percent><period>0.2</period></sin></magnitude><direction><time_for_rise>0.3"
    "</time_for_rise><sin><amplitude>20</amplitude><period>0.4</period></sin></direction>"
    "</horizontal>"
)
# Models in a wind: what a WindPlugin has, and the model.
WINDS = {
    "a wind": ("", body("a", "0 0 3 0 0 0.5", CUBE, 2.0).replace("<inertial", WINDY + "<inertial")),
    "gusts": (GUSTS, SWINGING.replace("<inertial>", WINDY + "<inertial>")),
    "a wind for one link": (
        GUSTS,
        SWINGING.replace("<inertial>", WINDY + "<inertial>", 2),
    ),
    "a wind for a model but for a link": (
        "",
        WINDY + SWINGING.replace("<inertial>", "<enable_wind>0</enable_wind><inertial>", 1),
    ),
}
ALL_MODELS = {**MODELS, **HARNESSES, **{name: (text, ()) for name, (_, text) in WINDS.items()}}


def wind(name):
    """Elements of a world of one of WINDS; of others none."""
    if name not in WINDS:
        return ""
    return (
        "<wind><linear_velocity>3 4 0.5</linear_velocity></wind>"
        f'<plugin name="wind" filename="libWindPlugin.so">{WINDS[name][0]}'
        "<vertical><time_for_rise>0.2</time_for_rise></vertical>"
        "<force_approximation_scaling_factor>2</force_approximation_scaling_factor></plugin>"
    )


def model(name):
    """The text of one of MODELS or HARNESSES."""
    return f'<model name="bot">{ALL_MODELS[name][0]}</model>'


def recorded():
    """Name -> {step: position [m] and quaternion of the base's center of mass} in Gazebo."""
    return json.loads(RECORD.read_text(encoding="utf-8"))
