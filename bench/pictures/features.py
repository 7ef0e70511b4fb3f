"""A world with one place for each feature of cameras, and what its cameras see in Paddock.

Each place has a camera or several, which see nothing of the others. The same file runs in Gazebo.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace

import numpy as np
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.plugins.depth_cameras import DepthCameraSpec
from bullet_sim.pose import Pose
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.sensors import camera
from bullet_sim.world import World
from PIL import Image

SPACING = 200.0  # [m] from place to place, along y
WIDTH, HEIGHT = 320, 240  # [px] of each camera


@dataclass(frozen=True)
class Place:
    """One camera and what it sees.

    Attributes:
        things: SDF of <visual>s, in meters from the camera's foot: x ahead, y left, z up.
        camera: SDF of its <camera>, besides size and angle.
        plugin: SDF of its <plugin>, besides names.
        library: of the plugin.
        height, pitch: of the camera [m], [rad].
        noise: its images differ from each other by noise.
        light: SDF of a <light> or of other parts of the world at the camera's foot, besides its
            name; '': none.
        kind: type of the sensor; '': that of the library.
    """

    things: str
    camera: str = "<clip><near>0.1</near><far>60</far></clip>"
    plugin: str = ""
    library: str = "camera"
    height: float = 1.0
    pitch: float = 0.0
    noise: bool = False
    light: str = ""
    kind: str = ""


def _visual(shape, pose, material):
    return f"<visual name='NAME'><pose>{pose}</pose><geometry>{shape}</geometry>{material}</visual>"


def _box(size, pose, material=""):
    return _visual(f"<box><size>{size}</size></box>", pose, material)


def _plane(size, pose, material=""):
    shape = f"<plane><normal>0 0 1</normal><size>{size}</size></plane>"
    return _visual(shape, pose, material)


def _color(ambient, diffuse=None, rest=""):
    diffuse = diffuse or ambient
    return f"<material><ambient>{ambient}</ambient><diffuse>{diffuse}</diffuse>{rest}</material>"


def _script(name, rest=""):
    return (
        "<material><script><uri>file://FOLDER</uri>"
        f"<name>Features/{name}</name></script>{rest}</material>"
    )


GRAY = _color("0.5 0.5 0.5 1")
FLOOR = _plane("60 60", "20 0 0 0 0 0", GRAY)
LENS = "<distortion><k1>{}</k1><k2>{}</k2><k3>0</k3><p1>{}</p1><p2>{}</p2></distortion>"
WALL = _box("0.1 8 6", "4 0 1 0 0 0", _script("Checker"))
CLIP = "<clip><near>0.1</near><far>60</far></clip>"
DEEP = (
    FLOOR
    + _box("1 1 1", "3 0.8 0.5 0 0 0.5", GRAY)
    + _visual("<sphere><radius>0.6</radius></sphere>", "4 -1 0.6 0 0 0", _color("0.2 0.6 0.2 1"))
    + _box("0.02 0.8 0.8", "2 -0.9 1.2 0 0 0", _script("Holes"))
    + _box("0.02 0.8 0.8", "2 0 1.5 0 0 0", _color("1 0 0 0.5", "1 0 0 0.5"))
    + _box("0.2 0.2 0.2", "0.35 0.3 1 0 0 0", _color("0.1 0.1 0.9 1"))
)
# Three rows of three panels, seen from ahead.
PANELS = (
    "TwoUnits", "AddUnits", "BlendUnits", "TwoPasses", "Holes", "Glass", "Turned", "Unlit", "Bumps",
)  # fmt: skip


def _panels():
    things = _box("0.1 8 6", "4.2 0 1 0 0 0", _color("0.2 0.2 0.6 1"))
    for index, name in enumerate(PANELS):
        row, column = divmod(index, 3)
        pose = f"4 {1.4 * (1 - column)} {1.0 + 1.05 * (1 - row)} 0 0 0"
        rest = ""
        if name == "Bumps":
            rest = (
                "<shader type='normal_map_tangent_space'>"
                "<normal_map>FOLDER/features_normals.png</normal_map></shader>"
            )
        things += _box("0.05 1.2 0.9", pose, _script(name, rest))
    return things


def _road():
    """A floor with lines to the horizon, a zebra crossing 1 mm above it, a ramp and a wall."""
    things = FLOOR + _plane("60 4", "30 0 0.002 0 0 0", _script("Lines"))
    for index in range(5):
        pose = f"6 {1.6 - 0.8 * index} 0.003 0 0 0"
        things += _plane("1.5 0.4", pose, _color("1 1 1 1"))
    things += _box("3 2 0.02", "10 3.6 0.4 0 -0.27 0", _color("0.6 0.4 0.2 1"))
    return things + _box("0.2 6 1.2", "16 -4 0.6 0 0 0.6", _color("0.7 0.3 0.3 1"))


def _polylines(*outlines):
    """SDF of <polyline>s of 0.6 m through corners x y, x y ..."""
    return "".join(
        "<polyline>"
        + "".join(f"<point>{corner}</point>" for corner in outline.split(", "))
        + "<height>0.6</height></polyline>"
        for outline in outlines
    )


PLACES = {
    "solids": Place(
        FLOOR
        + _box("1 1 1", "4 1.2 0.5 0 0 0.6", _color("0.8 0.1 0.1 1"))
        + _visual(
            "<sphere><radius>0.5</radius></sphere>",
            "4 -1.2 0.5 0 0 0",
            _color("0.1 0.7 0.1 1", None, "<specular>0.5 0.5 0.5 1</specular>"),
        )
        + _visual(
            "<cylinder><radius>0.4</radius><length>1</length></cylinder>",
            "5 0 0.5 0 0 0",
            _color("0.2 0.2 0.9 1", None, "<emissive>0.1 0.1 0 1</emissive>"),
        )
        + _box("0.2 12 2", "9 0 1 0 0 0.3", _color("0.9 0.8 0.5 1")),
        pitch=0.1,
    ),
    "road": Place(_road(), pitch=0.1),
    "lamp": Place(
        _plane("30 30", "10 0 0 0 0 0", _script("Dull"))
        + _plane("30 4", "10 3 0.01 0 0 0", _script("Shiny"))
        + _box("0.2 4 2", "8 -2 1 0 0 0", _script("Shiny")),
        pitch=0.1,
        light="<light type='point' name='NAME'><pose>3 Y 6 0 0 0</pose>"
        "<diffuse>0.5 0.4 0.3 1</diffuse><specular>0.5 0.5 0.5 1</specular><attenuation>"
        "<constant>0.4</constant><linear>0.05</linear><quadratic>0</quadratic><range>50</range>"
        "</attenuation><cast_shadows>0</cast_shadows></light>",
    ),
    "panels": Place(_panels()),
    "barrel": Place(WALL, CLIP + LENS.format(-0.3, 0.05, 0.0, 0.0)),
    "barrel_border": Place(
        WALL, CLIP + LENS.format(-0.3, 0.05, 0.0, 0.0), "<borderCrop>false</borderCrop>"
    ),
    "pincushion": Place(WALL, CLIP + LENS.format(0.25, 0.0, 0.0, 0.0)),
    "tangential": Place(WALL, CLIP + LENS.format(-0.2, 0.0, 0.03, -0.05)),
    "noise": Place(
        WALL,
        CLIP + "<noise><type>gaussian</type><mean>0.02</mean><stddev>0.05</stddev></noise>",
        noise=True,
    ),
    "clipped": Place(DEEP, "<clip><near>0.6</near><far>3.5</far></clip>"),
    "depth": Place(
        DEEP,
        "<clip><near>0.1</near><far>12</far></clip>",
        "<pointCloudCutoff>0.3</pointCloudCutoff><pointCloudCutoffMax>6.0</pointCloudCutoffMax>",
        "depth_camera",
    ),
    "kinect": Place(
        DEEP,
        "<clip><near>0.1</near><far>12</far></clip>",
        "<pointCloudCutoff>0.3</pointCloudCutoff><pointCloudCutoffMax>6.0</pointCloudCutoffMax>",
        "openni_kinect",
    ),
    "polylines": Place(
        FLOOR
        + _visual(
            _polylines(
                "0 0, 3 0, 3 2, 0 2",
                "0.5 0.5, 2.5 0.5, 2.5 1.5, 0.5 1.5",
                "1 0.8, 2 0.8, 1.5 1.3",
                "0 2.5, 1 2.5, 1 3.5",
            ),
            "4 -1.5 0 0 0 0",
            _color("0.8 0.4 0.1 1"),
        ),
        height=3.0,
        pitch=0.5,
    ),
    "intrinsics": Place(
        WALL,
        CLIP + "<lens><intrinsics><fx>200</fx><fy>260</fy><cx>100</cx><cy>90</cy><s>40</s>"
        "</intrinsics></lens>",
    ),
    "headlight": Place(
        _plane("30 30", "10 0 0 0 0 0", _script("Dull"))
        + _box("0.2 4 2", "8 -2 1 0 0 0", _script("Dull"))
        + "<light type='spot' name='NAME'><pose>0 0 1 0 -1.4 0</pose><direction>0 0 -1</direction>"
        "<diffuse>1 1 0.6 1</diffuse><specular>0 0 0 1</specular><attenuation><constant>0.2"
        "</constant><linear>0.05</linear><quadratic>0</quadratic><range>50</range></attenuation>"
        "<spot><inner_angle>0.3</inner_angle><outer_angle>0.8</outer_angle><falloff>1</falloff>"
        "</spot><cast_shadows>0</cast_shadows></light>",
        pitch=0.1,
    ),
    "wide": Place(
        WALL + FLOOR + _box("1 1 1", "-1 3 0.5 0 0 0.5", _color("0.1 0.7 0.2 1")),
        CLIP + "<lens><type>equidistant</type><scale_to_hfov>true</scale_to_hfov>"
        "<cutoff_angle>3.1415</cutoff_angle></lens>",
        kind="wideanglecamera",
    ),
    "road_element": Place(
        FLOOR,
        pitch=0.2,
        light="<road name='NAME'><width>2</width><point>3 Y 0.02</point><point>9 Y 0.02</point>"
        "<point>14 YPLUS 0.02</point></road>",
    ),
}

SCRIPT = """
material Features/Base { technique { pass {
ambient 1 1 1 1
diffuse 1 1 1 1
} } }
material Features/Checker : Features/Base { technique { pass { texture_unit {
texture features_checker.png
} } } }
material Features/Lines : Features/Base { technique { pass { texture_unit {
texture features_lines.png
filtering anisotropic
max_anisotropy 16
} } } }
material Features/TwoUnits : Features/Base { technique { pass {
texture_unit a {
texture features_checker.png
}
texture_unit b {
texture features_quarters.png
}
} } }
material Features/AddUnits : Features/Base { technique { pass {
texture_unit a {
texture features_checker.png
}
texture_unit b {
texture features_quarters.png
colour_op add
scale 0.5 0.5
}
} } }
material Features/BlendUnits : Features/Base { technique { pass {
texture_unit a {
texture features_checker.png
}
texture_unit b {
texture features_holes.png
colour_op alpha_blend
}
} } }
material Features/TwoPasses { technique {
pass {
ambient 0.5 0.5 0.5 1
diffuse 0.5 0.5 0.5 1
texture_unit {
texture features_checker.png
}
}
pass {
scene_blend add
ambient 0.3 0 0 1
diffuse 0.3 0 0 1
texture_unit {
texture features_checker.png
}
}
} }
material Features/Holes : Features/Base { technique { pass {
alpha_rejection greater 128
texture_unit {
texture features_holes.png
}
} } }
material Features/Glass : Features/Base { technique { pass {
scene_blend alpha_blend
depth_write off
texture_unit {
texture features_holes.png
}
} } }
material Features/Turned : Features/Base { technique { pass { texture_unit {
texture features_quarters.png
rotate 30
scale 0.7 0.7
scroll 0.2 0.1
} } } }
material Features/Unlit : Features/Base { technique { pass {
lighting off
texture_unit {
texture features_quarters.png
}
} } }
material Features/Dull { technique { pass {
ambient 0.2 0.2 0.2 1
diffuse 0.3 0.3 0.3 1
specular 0 0 0 1 0
} } }
material Features/Shiny { technique { pass {
ambient 0.2 0.2 0.2 1
diffuse 0.3 0.3 0.3 1
specular 0.25 0.25 0.25 2
} } }
material Features/Bumps : Features/Base { technique { pass { texture_unit {
texture features_gray.png
} } } }
"""


def _images():
    """Name -> pixels of the textures."""
    rows, columns = np.indices((256, 256))
    checker = np.where((rows // 32 + columns // 32) % 2, 230, 60)[..., None].astype(np.uint8)
    checker = np.repeat(checker, 3, axis=2)
    checker[:, :, 0] = np.where(rows < 32, 230, checker[:, :, 0])  # the upper edge is red
    quarters = np.zeros((64, 64, 3), np.uint8)
    quarters[:32, :32], quarters[:32, 32:] = (255, 60, 60), (60, 255, 60)
    quarters[32:, :32], quarters[32:, 32:] = (60, 60, 255), (255, 255, 60)
    holes = np.full((64, 64, 4), (250, 150, 20, 255), np.uint8)
    holes[(np.indices((64, 64)) // 16 % 2).sum(axis=0) == 1, 3] = 60
    lines = np.full((512, 1024, 3), 70, np.uint8)
    lines[30:42], lines[470:482] = 240, 240
    lines[250:262, np.arange(1024) % 64 < 32] = (240, 220, 40)
    waves = 0.8 * np.cos(np.indices((64, 64))[1] / 64.0 * 4.0 * np.pi)
    normals = np.stack([waves, np.zeros_like(waves), np.sqrt(1.0 - waves**2)], axis=2)
    return {
        "checker": checker,
        "quarters": quarters,
        "holes": holes,
        "lines": lines,
        "gray": np.full((8, 8, 3), 200, np.uint8),
        "normals": np.rint(127.5 * (normals + 1.0)).astype(np.uint8),
    }


def write(folder, seen_as=None, places=tuple(PLACES)):
    """Write features.world with its images and its material script into a folder.

    Args:
        folder: is made.
        seen_as: path of the folder where the world will be loaded; None: the same.
        places: names of those it has.

    Returns:
        Path of the world file.
    """
    os.makedirs(folder, exist_ok=True)
    for name, pixels in _images().items():
        Image.fromarray(pixels).save(os.path.join(folder, f"features_{name}.png"))
    with open(os.path.join(folder, "features.material"), "w", encoding="utf-8") as file:
        file.write(SCRIPT.replace("{", "\n{\n").replace("}", "\n}\n"))
    path = os.path.join(folder, "features.world")
    with open(path, "w", encoding="utf-8") as file:
        file.write(world_text(os.path.abspath(seen_as or folder), places))
    return path


def world_text(folder, places=tuple(PLACES)):
    """SDF of the world with some places; its images are in `folder`."""
    models = "".join(
        _model(name, place, index)
        for index, (name, place) in enumerate(PLACES.items())
        if name in places
    )
    lights = "".join(
        place.light.replace("NAME", f"lamp_{name}")
        .replace("YPLUS", str(SPACING * index + 4))
        .replace("Y", str(SPACING * index))
        for index, (name, place) in enumerate(PLACES.items())
        if name in places
    )
    return (
        "<?xml version='1.0'?>\n<sdf version='1.6'><world name='features'>"
        "<scene><ambient>0.4 0.4 0.4 1</ambient><background>0.7 0.7 0.7 1</background>"
        "<shadows>0</shadows></scene>"
        "<light name='sun' type='directional'><pose>0 0 10 0 0 0</pose>"
        "<diffuse>0.8 0.8 0.8 1</diffuse><specular>0.2 0.2 0.2 1</specular>"
        "<direction>0.6 -0.3 -0.9</direction><cast_shadows>0</cast_shadows></light>"
        f"{lights}{models}</world></sdf>\n"
    ).replace("FOLDER", folder)


def _model(name, place, index):
    """SDF of a place: a static model with what is there and its camera."""
    visuals = place.things.split("name='NAME'")
    things = visuals[0] + "".join(f"name='v{i}'{rest}" for i, rest in enumerate(visuals[1:]))
    kind = place.kind or ("depth" if place.library != "camera" else "camera")
    return (
        f"<model name='{name}'><static>1</static><pose>0 {SPACING * index} 0 0 0 0</pose>"
        f"<link name='link'>{things}"
        f"<sensor name='{name}' type='{kind}'><pose>0 0 {place.height} 0 {place.pitch} 0</pose>"
        "<update_rate>2</update_rate><always_on>1</always_on><camera>"
        f"<horizontal_fov>1.2</horizontal_fov><image><width>{WIDTH}</width>"
        f"<height>{HEIGHT}</height><format>R8G8B8</format></image>{place.camera}</camera>"
        f"<plugin name='{name}' filename='libgazebo_ros_{place.library}.so'>"
        f"<cameraName>{name}</cameraName><imageTopicName>image_raw</imageTopicName>"
        "<cameraInfoTopicName>camera_info</cameraInfoTopicName>"
        f"<frameName>{name}</frameName>{place.plugin}</plugin></sensor></link></model>"
    )


@dataclass
class Seen:
    """What a camera saw.

    Attributes:
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32 [m] of its message, NaN: unknown; None: it measures none.
        points: (H, W, 3) float32 [m] in the optical frame; None, likewise.
    """

    rgb: np.ndarray
    depth: np.ndarray | None = None
    points: np.ndarray | None = None


QUALITY = Quality("false", "false")  # as by default without a GPU


def render(folder, quality=QUALITY):
    """What the cameras of a written world see in Paddock, without ROS.

    Args:
        folder: as write() has it.

    Returns:
        dict: name of the place -> Seen.
    """
    with open(os.path.join(folder, "features.world"), encoding="utf-8") as file:
        described = parse_world(file.read(), lambda uri: re.sub("^file://", "", uri), "features")
    world, renderer, seen = World(), GlRenderer(quality), {}
    try:
        world.load(described)
        renderer.sync_sources(world.sources(), described.scene)
        renderer.apply(world.snapshot())
        for name in PLACES:
            model = world.model(name)
            (spec,) = model.description.sensors
            part, offset = model.link_in_body(spec.link)
            pose = offset * Pose.from_xyz_rpy(*spec.pose)
            request = CameraRequest.from_spec(spec, model.source.key, model.row(part))
            request = replace(request, pose=(pose.position, pose.rpy))
            rgb, depth = renderer.render_with_depth(request)
            seen[name] = Seen(rgb.copy())
            if isinstance(spec, DepthCameraSpec):
                known = camera.within(depth, spec.cutoff, spec.cutoff_max)
                k = camera.intrinsics(spec.width, spec.height, spec.horizontal_fov)
                seen[name] = Seen(rgb.copy(), known, camera.points(known, k))
    finally:
        renderer.close()
        world.close()
    return seen
