"""Materials as real Gazebo renders them: <material>, standard ones, scripts, mesh files."""

import numpy as np
import pytest
from bullet_sim.description.model import Finish, Geometry, Shape, TextureMapping, VisualLink
from bullet_sim.description.world import Scene
from bullet_sim.formats.ogre import complete, look, read_script
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.pose import Pose
from bullet_sim.render.request import CameraRequest
from bullet_sim.snapshot import BodySource, Snapshot
from gazebo_looks import GIVEN, NAMED, PASSES
from PIL import Image

SHADOWS = "false"

GAZEBO = (
    "<material><script><uri>file://media/materials/scripts/gazebo.material</uri>"
    "<name>Gazebo/{}</name></script>{}"
)
BOX = "<box><size>0.9 0.9 0.01</size></box>"
WORLD = """<sdf version="1.6"><world name="w"><scene><shadows>0</shadows></scene>
<include><uri>model://sun</uri></include><model name="m"><static>1</static><link name="l">
<visual name="v"><geometry>{}</geometry>{}</visual></link></model></world></sdf>"""
QUARTERS = ((0.15, 0.3), (0.15, -0.3), (-0.15, 0.3), (-0.15, -0.3))  # x, y [m] on the box
HEIGHT, SIZE, ANGLE = 20.0, 80, 0.05  # of the camera: [m], [px], [rad]


@pytest.fixture(name="folder", scope="module")
def _folder(tmp_path_factory):
    """Images: four quarters in four colors with a bar in the first, gray, half of it a hole."""
    folder = tmp_path_factory.mktemp("looks")
    quarters = np.zeros((64, 64, 3), np.uint8)
    quarters[:32, :32], quarters[:32, 32:] = (255, 0, 0), (0, 255, 0)
    quarters[32:, :32], quarters[32:, 32:] = (0, 0, 255), (255, 255, 0)
    quarters[4:12, 4:28] = 255
    holes = np.zeros((64, 64, 4), np.uint8)
    holes[:, :, 0], holes[:, :32, 3], holes[:, 32:, 3] = 255, 255, 60
    for name, pixels in (("quarters", quarters), ("holes", holes)):
        Image.fromarray(pixels).save(folder / f"{name}.png")
    Image.new("RGB", (8, 8), (128, 128, 128)).save(folder / "half.png")
    return folder


def resolve(uri):
    if not uri.startswith("file:///"):
        raise ValueError("searched nowhere")
    return uri[len("file://") :]


def seen(gl, shapes, scene):
    """RGB of the four quarters of shapes on one body, from above."""
    gl.sync_sources([BodySource(1, True, (VisualLink(shapes=tuple(shapes)),))], scene)
    pose = ((0.0, 0.0, HEIGHT), (0.0, np.pi / 2, 0.0))
    request = CameraRequest("eye", None, 0, pose, SIZE, SIZE, ANGLE, 0.1, 100.0)
    picture = gl.draw(Snapshot(0.0, 0, ()), request)
    focal = SIZE / 2.0 / np.tan(ANGLE / 2.0)
    half = SIZE / 2.0
    return np.array(
        [
            picture[int(half - x * focal / HEIGHT), int(half - y * focal / HEIGHT)]
            for x, y in QUARTERS
        ],
        int,
    )


def pictured(gl, geometry, material=""):
    world = parse_world(WORLD.format(geometry, material), resolve, "w")
    (model, _) = world.models[0]
    return seen(gl, model.links["l"].visuals, world.scene)


def written(text):
    """<material> and <transparency> of a key of GIVEN."""
    inside, after = "", ""
    for part in text.split("; "):
        tag, value = part.split(": ")
        if tag == "transparency":
            after = f"<transparency>{value}</transparency>"
        elif tag == "script":
            inside += f"<script><name>{value}</name></script>"
        else:
            inside += f"<{tag}>{value}</{tag}>"
    return f"<material>{inside}</material>{after}"


@pytest.mark.parametrize("material", GIVEN)
def test_given_materials(gl, material):
    assert np.abs(pictured(gl, BOX, written(material)) - GIVEN[material]).max() <= 4


@pytest.mark.parametrize("name", NAMED)
def test_standard_materials(gl, name):
    found = pictured(gl, BOX, GAZEBO.format(name, "</material>"))
    if name in ("CeilingTiled", "Residential", "Grass"):  # drawn, with another grain
        found = found.mean(axis=0)
    # Grass, which repeats 50 times, shows its smallest images: darker than the image with the Mesa
    # that Gazebo's were measured with
    assert np.abs(found - NAMED[name]).max() <= (7 if name == "Grass" else 4)


def scripted(folder, text, name="Own/It"):
    (folder / "own.material").write_text(text)
    return f"<material><script><uri>file://{folder}</uri><name>{name}</name></script></material>"


@pytest.mark.parametrize("body", PASSES)
def test_passes_of_scripts(gl, folder, body):
    """Where an image is turned or moved, which of its colors is where."""
    text = f"material Own/It\n{{\n technique\n {{\n  pass\n  {{\n{body}\n  }}\n }}\n}}\n"
    exact = "quarters" not in body
    found = pictured(gl, BOX, scripted(folder, text.replace("{ ", "{\n").replace(" }", "\n}")))
    assert np.abs(found - np.array(PASSES[body])).max() <= (4 if exact else 150), found


def test_passes_and_parents_of_scripts(gl, folder):
    """A pass is added, a child darkens its parent's, a grandchild has another image."""
    both = (
        "material Own/It { technique { pass {\nambient 1 0 0\ndiffuse 1 0 0\n} pass {\n"
        "scene_blend add\nambient 0 0.5 0\ndiffuse 0 0.5 0\n} } }"
    )
    assert np.abs(pictured(gl, BOX, scripted(folder, both)) - (255, 139, 0)).max() <= 4
    family = (
        "material Base { technique { pass { texture_unit {\ntexture half.png\n} } } }\n"
        "material Child : Base { technique { pass {\nambient 0 0 0\ndiffuse 1 0 0 1\n} } }\n"
        'material "Grand Child" : Child\n{ technique { pass { texture_unit {\ntexture '
        "quarters.png\n} } } } // the end"
    )
    child = pictured(gl, BOX, scripted(folder, family, "Child"))
    assert np.abs(child - (89, 1, 0)).max() <= 4
    grandchild = pictured(gl, BOX, scripted(folder, family, "Grand Child"))
    expected = ((176, 0, 0), (0, 0, 0), (0, 0, 0), (176, 0, 0))
    assert np.abs(grandchild - np.array(expected)).max() <= 4


@pytest.mark.parametrize(
    "text",
    ["", "material", "material A {", "} } material A\n{\ntechnique {", "{ { {", 'material "x'],
)
def test_broken_scripts_end_where_they_end(text):
    materials = {section.name: section for section in read_script(text)}
    assert set(materials) <= {"", "A", '"x'}
    for name in materials:
        assert look(complete(name, materials)).texture == ""
    loop = {
        section.name: section for section in read_script("material A : B {}\nmaterial B : A {}")
    }
    assert complete("A", loop) is not None and complete("C", loop) is None


@pytest.mark.parametrize("words", ["scale 0 0", "scale nan 1", "rotate x", "scroll 1"])
def test_bad_numbers_of_a_texture_unit_count_as_none(words):
    text = (
        f"material A {{ technique {{ pass {{ texture_unit {{\ntexture a.png\n{words}\n}} }} }} }}"
    )
    (material,) = read_script(text)
    assert look(material).finish.mapping == TextureMapping()


COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>
<unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset><library_images><image id="i">
<init_from>IMAGE.png</init_from></image></library_images><library_effects><effect id="e">
<profile_COMMON><newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="common">EFFECT</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="12">
-0.45 -0.45 0.005 0.45 -0.45 0.005 0.45 0.45 0.005 -0.45 0.45 0.005</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y"
type="float"/><param name="Z" type="float"/></accessor></technique_common></source><source id="u">
<float_array id="ua" count="8">0 0 1 0 1 1 0 1</float_array><technique_common><accessor source="#ua"
count="4" stride="2"><param name="S" type="float"/><param name="T" type="float"/></accessor>
</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles material="m" count="2"><input semantic="VERTEX" source="#v" offset="0"/><input
semantic="TEXCOORD" source="#u" offset="1"/><p>0 0 1 1 2 2 0 0 2 2 3 3</p></triangles></mesh>
</geometry></library_geometries><library_visual_scenes><visual_scene id="sc"><node id="n">
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m"
target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#sc"/></scene></COLLADA>"""
IMAGE = '<diffuse><texture texture="t" texcoord="UV"/></diffuse>'
RED = "<diffuse><color>0.8 0.2 0.2 1</color></diffuse>"
BLACK = "<ambient><color>0 0 0 1</color></ambient>"


@pytest.mark.parametrize(
    "effect, expected",
    [
        (f"<lambert>{RED}</lambert>", (182, 76, 76)),
        (
            f"<phong>{BLACK}{RED}<specular><color>0.5 0.5 0.5 1</color></specular>"
            "<shininess><float>50</float></shininess></phong>",
            (146, 40, 40),
        ),
        (f"<lambert>{IMAGE}</lambert>", (110, 110, 110)),
        (f"<phong>{BLACK}{IMAGE}</phong>", (89, 89, 89)),
        (
            f"<phong><emission><color>0.5 0.5 0 1</color></emission>{BLACK}{IMAGE}</phong>",
            (153, 153, 91),
        ),
        ("<lambert><diffuse><color>0.8 0.2 0.2 0.4</color></diffuse></lambert>", (179, 137, 138)),
        (
            f"<phong>{RED}<transparency><float>0.7</float></transparency></phong>",
            (182, 76, 76),
        ),
        (
            f'<phong>{RED}<transparent opaque="RGB_ZERO"><color>0.6 0.6 0.6 1</color></transparent>'
            "<transparency><float>1</float></transparency></phong>",
            (179, 137, 138),
        ),
        (
            f'<phong>{RED}<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent>'
            "<transparency><float>1</float></transparency></phong>",
            (182, 76, 76),
        ),
    ],
)
def test_materials_of_collada(gl, folder, tmp_path, effect, expected):
    path = tmp_path / "plate.dae"
    path.write_text(COLLADA.replace("IMAGE", str(folder / "half")).replace("EFFECT", effect))
    mesh = f"<mesh><uri>file://{path}</uri></mesh>"
    assert np.abs(pictured(gl, mesh) - expected).max() <= 4
    red = pictured(gl, mesh, GAZEBO.format("Red", "</material>"))
    assert np.abs(red - NAMED["Red"]).max() <= 4, "the file's image is replaced, too"


@pytest.mark.parametrize(
    "material, expected",
    [
        ("Kd 0.8 0.2 0.2", (141, 35, 35)),
        ("Ka 1 1 1\nKd 0.8 0.2 0.2\nKs 0.5 0.5 0.5\nNs 2", (255, 161, 161)),
        ("Ka 1 1 1\nKd 1 1 1\nmap_Kd half.png", (140, 140, 140)),
        ("map_Kd half.png", (53, 53, 53)),
        ("Ka 0 0 0\nKd 0 0 0\nKe 0.5 0.25 0", (128, 64, 0)),
        ("Ka 1 1 1\nKd 0.8 0.2 0.2\nd 0.4", (204, 162, 163)),
    ],
)
def test_materials_of_obj(gl, folder, tmp_path, material, expected):
    material = material.replace("half.png", str(folder / "half.png"))
    (tmp_path / "plate.mtl").write_text(f"newmtl m\n{material}\n")
    (tmp_path / "plate.obj").write_text(
        "mtllib plate.mtl\nv -0.45 -0.45 0.005\nv 0.45 -0.45 0.005\nv 0.45 0.45 0.005\n"
        "v -0.45 0.45 0.005\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\n"
        "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    )
    found = pictured(gl, f"<mesh><uri>file://{tmp_path}/plate.obj</uri></mesh>")
    assert np.abs(found - expected).max() <= 4


def test_a_visual_without_material_is_white(gl):
    assert (pictured(gl, BOX) == 255).all()


@pytest.mark.parametrize(
    "geometry, quarters",
    [
        (Geometry("box", (0.9, 0.9, 0.01)), "red green blue yellow"),
        (Geometry("box", (0.9, 0.9, 0.01), flat=True), "green yellow red blue"),
        (Geometry("sphere", (0.6,)), "blue yellow green"),
    ],
)
def test_how_images_lie_on_solids(gl, folder, geometry, quarters):
    """From above: upper left, upper right, ... (Gazebo's pictures of them)."""
    colors = {
        "red": (255, 0, 0),
        "green": (0, 255, 0),
        "blue": (0, 0, 255),
        "yellow": (255, 255, 0),
    }
    shape = Shape(geometry, Pose(), texture=str(folder / "quarters.png"), painted=True)
    dark = Scene(ambient=(1.0,) * 3, lights=())
    found = seen(gl, [shape], dark)
    if geometry.kind == "sphere":  # its left edge of the image is on top
        names = [min(colors, key=lambda name: np.abs(rgb - colors[name]).sum()) for rgb in found]
        assert names == ["red", "blue", "green", "yellow"]
        return
    expected = [colors[name] for name in quarters.split()]
    assert (np.abs(found - np.array(expected)).max(axis=1) <= 4).sum() >= 3, "one may be the bar"


def test_a_plane_is_not_seen_from_below(gl):
    floor = Shape(Geometry("box", (2.0, 2.0, 0.01), flat=True), Pose((0.0, 0.0, 1.0)))
    gl.sync_sources([BodySource(1, True, (VisualLink(shapes=(floor,)),))], Scene())
    up = CameraRequest("eye", None, 0, ((0, 0, 0), (0, -np.pi / 2, 0)), 8, 8, 0.5, 0.1, 10.0)
    assert np.abs(gl.draw(Snapshot(0.0, 0, ()), up).astype(int) - 178).max() <= 1


def test_an_image_is_as_bright_far_away_as_near_by(gl, folder):
    """The mean of a grainy image, at each of the distances from 0.3 to 16 pixels a texel."""
    grain = np.random.default_rng(1).integers(40, 100, (1024, 1024, 3), dtype=np.uint8)
    Image.fromarray(grain).save(folder / "grain.png")
    shape = Shape(
        Geometry("box", (4.0, 4.0, 0.01), flat=True),
        texture=str(folder / "grain.png"),
        painted=True,
    )
    gl.sync_sources(
        [BodySource(1, True, (VisualLink(shapes=(shape,)),))],
        Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=()),
    )
    for height in (2.0, 8.0, 30.0, 100.0):
        pose = ((0.0, 0.0, height), (0.0, np.pi / 2, 0.0))
        request = CameraRequest("eye", None, 0, pose, 64, 64, 1.5 / height, 0.1, 200.0)
        mean = gl.draw(Snapshot(0.0, 0, ()), request).mean()
        assert abs(mean - grain.mean()) < 1.0, height


def test_a_line_far_away_is_a_line(gl, folder):
    """White lines of 5 cm on black, 60 m away: Gazebo has five smaller images of a texture."""
    lines = np.zeros((1024, 1024, 3), np.uint8)
    lines[:, 500:524] = 255
    Image.fromarray(lines).save(folder / "lines.png")
    road = Shape(
        Geometry("box", (200.0, 2.2, 0.01), flat=True),
        Pose((60.0, 0.0, -0.5)),
        texture=str(folder / "lines.png"),
        painted=True,
        finish=Finish(mapping=TextureMapping((0.0, 1.0, 0.0, 1.0, 0.0, 0.0))),
    )
    gl.sync_sources(
        [BodySource(1, True, (VisualLink(shapes=(road,)),))],
        Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=()),
    )
    request = CameraRequest("eye", None, 0, ((0, 0, 0), (0, 0, 0)), 640, 480, 1.0, 0.1, 200.0)
    picture = gl.draw(Snapshot(0.0, 0, ()), request)
    row = 240 + round(0.5 / 40.0 * 320 / np.tan(0.5))
    assert picture[row].max() > 40, "40 m away"
