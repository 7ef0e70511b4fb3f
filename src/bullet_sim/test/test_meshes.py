"""Meshes and images: what PyBullet gets instead of the files of the description."""

import struct

import numpy as np
import pytest
from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.model import Geometry, Link, Shape
from bullet_sim.engine.api import Rays
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.meshes.prepare import prepare_meshes
from bullet_sim.meshes.read import MeshFileResolver
from bullet_sim.meshes.triangles import mesh_triangles
from bullet_sim.pose import Pose
from bullet_sim.world import World
from PIL import Image

TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)]
ASCII_STL = (
    "solid t\n"
    + "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*TETRAHEDRON[i]) for i in face)
        + "endloop\nendfacet\n"
        for face in FACES
    )
    + "endsolid t\n"
)
OBJ = "".join("v {} {} {}\n".format(*v) for v in TETRAHEDRON) + "".join(
    "f {} {} {}\n".format(*(i + 1 for i in face)) for face in FACES
)
DAE = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
 <library_effects>{effects}</library_effects><library_materials>{materials}</library_materials>
 <library_geometries><geometry id="g" name="g"><mesh>
  <source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 2</float_array>
   <technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
   <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
  </source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="2" material="a"><input semantic="VERTEX" source="#v" offset="0"/>
   <p>0 2 1 0 3 2</p></triangles>
  <triangles count="2" material="b"><input semantic="VERTEX" source="#v" offset="0"/>
   <p>0 1 3 1 2 3</p></triangles></mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s"><node id="n"><translate>10 0 0</translate>
  <instance_geometry url="#g"><bind_material><technique_common>
   <instance_material symbol="a" target="#ma"/><instance_material symbol="b" target="#mb"/>
  </technique_common></bind_material></instance_geometry></node></visual_scene>
 </library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""".format(
    effects="".join(
        f'<effect id="e{k}"><profile_COMMON><technique sid="c"><lambert><diffuse><color>{color}'
        "</color></diffuse></lambert></technique></profile_COMMON></effect>"
        for k, color in (("a", "1 0 0 1"), ("b", "0 0 1 1"))
    ),
    materials="".join(
        f'<material id="m{k}"><instance_effect url="#e{k}"/></material>' for k in "ab"
    ),
)


def binary_stl(corners=TETRAHEDRON):
    """A binary STL of the tetrahedron."""
    return (
        b"\0" * 80
        + struct.pack("<I", len(FACES))
        + b"".join(
            struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in corners[i]), 0)
            for face in FACES
        )
    )


def localised(tmp_path, name, content, role="visuals", scale=(1.0, 1.0, 1.0), **values):
    """Shapes that stand for a mesh file, and the warnings."""
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    geometry = Geometry(
        "mesh",
        path=str(path),
        scale=scale,
        submesh=values.pop("submesh", ""),
        centered=values.pop("centered", False),
    )
    link = Link("l")
    getattr(link, role).append(Shape(geometry, name="s", **values))
    warnings = []

    def warn(text, cause, item):
        assert cause and item
        warnings.append(text)

    prepare_meshes(LumpedModel({"l": link}, (), "l", {}), str(tmp_path / "out"), warn)
    return getattr(link, role), warnings


def corners(shape):
    """(n, 3) corners of a shape's OBJ."""
    with open(shape.geometry.path, encoding="utf-8") as file:
        return np.array(
            [[float(x) for x in line.split()[1:]] for line in file if line.startswith("v ")]
        )


@pytest.mark.parametrize(
    "name, content",
    [("m.obj", "mtllib m.mtl\nusemtl a\n" + OBJ), ("m.stl", binary_stl()), ("M.STL", binary_stl())],
)
@pytest.mark.parametrize("role", ["visuals", "collisions"])
def test_what_pybullet_reads_stays(tmp_path, name, content, role):
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (shape,), warnings = localised(tmp_path, name, content, role)
    assert shape.geometry.path == str(tmp_path / name) and warnings == []


@pytest.mark.parametrize("role", ["visuals", "collisions"])
def test_ascii_stl_becomes_obj(tmp_path, role):
    (shape,), _ = localised(tmp_path, "m.stl", ASCII_STL, role, scale=(2.0, 1.0, 1.0))
    assert shape.geometry.path.endswith(".obj") and shape.geometry.scale == (2.0, 1.0, 1.0)
    assert {tuple(row) for row in corners(shape)} == set(
        map(tuple, map(lambda v: tuple(map(float, v)), TETRAHEDRON))
    )


@pytest.mark.parametrize(
    "text",
    [
        DAE,
        DAE.replace('"pa"', '"p<a>"').replace("#pa", "#p<a>"),
        DAE.replace('"g"', '"g & h"').replace("#g", "#g & h"),
        "<!-- made by hand -->" + DAE,
        DAE.replace('meter="0.0254"', "meter=0.0254"),
        DAE.replace("utf-8", "utf-16").encode("utf-16"),
        DAE.replace("\n", "\r\n"),
    ],
    ids=["sound", "angles", "ampersand", "comment", "quotes", "UTF-16", "Windows"],
)
def test_dae_units_places_and_colours(tmp_path, text):
    shapes, warnings = localised(tmp_path, "m.dae", text)
    assert warnings == []
    assert sorted(shape.color for shape in shapes) == [(0, 0, 1, 1), (1, 0, 0, 1)]
    points = np.vstack([corners(shape) for shape in shapes])
    inch = 0.0254
    np.testing.assert_allclose(points.min(axis=0), (10 * inch, 0, 0), atol=1e-6)
    np.testing.assert_allclose(points.max(axis=0), (11 * inch, inch, 2 * inch), atol=1e-6)


@pytest.mark.parametrize(
    "content, values, color",
    [
        (OBJ, {}, (0.7, 0.7, 0.7, 1)),
        (OBJ, {"color": (0, 1, 0, 1)}, (0, 1, 0, 1)),
        ("mtllib m.mtl\nusemtl a\n" + OBJ, {"color": (0, 1, 0, 1), "painted": True}, (0, 1, 0, 1)),
        ("mtllib gone.mtl\nusemtl a\n" + OBJ, {"color": (0, 0, 1, 1)}, (0, 0, 1, 1)),
    ],
)
def test_obj_gets_a_material_of_the_right_colour(tmp_path, content, values, color):
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (shape,), _ = localised(tmp_path, "m.obj", content, **values)
    assert shape.color[:3] == pytest.approx(color[:3], abs=0.01)
    library = open(shape.geometry.path.replace(".obj", ".mtl"), encoding="utf-8").read()
    found = next(line for line in library.splitlines() if line.startswith("Kd"))
    assert [float(word) for word in found.split()[1:]] == pytest.approx(color[:3], abs=0.01)


def test_dae_collides_as_one_part_and_takes_paint(tmp_path):
    (collision,), _ = localised(tmp_path, "m.dae", DAE, "collisions")
    assert len({tuple(row) for row in corners(collision).round(6)}) == 4
    shapes, _ = localised(tmp_path, "m.dae", DAE, color=(0, 1, 0, 1), painted=True)
    assert {shape.color for shape in shapes} == {(0, 1, 0, 1)}


def test_mirrored_mesh_keeps_its_outside_out(tmp_path):
    (shape,), _ = localised(tmp_path, "m.obj", OBJ, scale=(1.0, -2.0, 1.0))
    assert shape.geometry.scale == (1.0, 2.0, 1.0)
    with open(shape.geometry.path, encoding="utf-8") as file:
        faces = [
            [int(word.split("/")[0]) - 1 for word in line.split()[1:]]
            for line in file
            if line.startswith("f ")
        ]
    points = corners(shape)
    assert points[:, 1].min() == -1.0
    volume = sum(np.dot(points[a], np.cross(points[b], points[c])) for a, b, c in faces) / 6
    assert volume == pytest.approx(1 / 6)  # negative when it is inside out


def test_obj_with_two_materials_becomes_two_parts(tmp_path):
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n")
    content = "mtllib m.mtl\n" + OBJ.replace("f 1 3 2", "usemtl a\nf 1 3 2").replace(
        "f 1 2 4", "usemtl b\nf 1 2 4"
    )
    shapes, _ = localised(tmp_path, "m.obj", content)
    assert sorted(shape.color[:3] for shape in shapes) == [(0, 0, 1), (1, 0, 0)]


@pytest.mark.parametrize(
    "name, content, words",
    [
        ("a.obj", "v 0 0 0\n", "no faces"),
        ("a.obj", "", "empty"),
        ("a.obj", OBJ.replace("v 1 0 0", "v nan 0 0"), "no numbers"),
        ("a.obj", OBJ + "f 1 2 99\n", "99"),
        ("a.obj", OBJ + "f 0 1 2\n", "names number 0"),
        ("a.obj", OBJ + "f 1 2 -99\n", "names number -99"),
        ("a.obj", OBJ + "f a b c\n", "no list of numbers"),
        ("a.stl", binary_stl([(np.nan, 0, 0)] * 4), "no numbers"),
        ("a.stl", b"\0" * 80 + struct.pack("<I", 0), "no triangles"),
        ("a.stl", "solid x\nendsolid x\n", "a.stl"),
        ("a.stl", b"\x01\x02", "no triangles"),
        ("a.stl", binary_stl()[:-60], "cut off after 2 triangles"),
        ("a.stl", ASCII_STL.replace("vertex 0 0 1", "vertex 0 0", 1), "lacks a corner"),
        ("a.dae", "<COLLADA", "cannot be read"),
        ("a.dae", "no xml", "cannot be read"),
        ("a.dae", DAE.replace(">0 0 0 1 0 0 ", ">1e30 0 0 1 0 0 "), "beyond"),
    ],
)
@pytest.mark.parametrize("role", ["visuals", "collisions"])
def test_bad_files_are_left_out_with_a_sentence(tmp_path, name, content, words, role):
    shapes, warnings = localised(tmp_path, name, content, role)
    assert shapes == [] and len(warnings) == 1
    assert words in warnings[0] and name in warnings[0] and "link 'l'" in warnings[0]


def test_submesh_and_its_names(tmp_path):
    content = "o first\n" + OBJ + "o second\nv 5 5 5\nv 7 5 5\nv 5 9 5\nf 5 6 7\n"
    (shape,), warnings = localised(tmp_path, "m.obj", content, submesh="second", centered=True)
    assert warnings == []
    np.testing.assert_allclose(np.ptp(corners(shape), axis=0), (2, 4, 0))
    np.testing.assert_allclose(corners(shape).max(axis=0), (1, 2, 0))
    shapes, warnings = localised(tmp_path, "m.obj", content, submesh="third")
    assert shapes == [] and "no part 'third'" in warnings[0] and "second" in warnings[0]


INSTANCE = DAE[DAE.index("<instance_geometry") : DAE.index("</node>")]
SKIN = """<library_controllers><controller id="c"><skin source="#g">
<bind_shape_matrix>1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>
<source id="j"><Name_array id="ja" count="1">b</Name_array><technique_common>
<accessor source="#ja" count="1" stride="1"><param name="JOINT" type="name"/></accessor>
</technique_common></source><source id="i"><float_array id="ia" count="16">1 0 0 0 0 1 0 0 0 0 1 0
0 0 0 1</float_array><technique_common><accessor source="#ia" count="1" stride="16">
<param name="TRANSFORM" type="float4x4"/></accessor></technique_common></source>
<source id="w"><float_array id="wa" count="1">1</float_array><technique_common>
<accessor source="#wa" count="1" stride="1"><param name="WEIGHT" type="float"/></accessor>
</technique_common></source><joints><input semantic="JOINT" source="#j"/>
<input semantic="INV_BIND_MATRIX" source="#i"/></joints><vertex_weights count="4">
<input semantic="JOINT" source="#j" offset="0"/><input semantic="WEIGHT" source="#w" offset="1"/>
<vcount>1 1 1 1</vcount><v>0 0 0 0 0 0 0 0</v></vertex_weights></skin></controller>
</library_controllers><library_visual_scenes>"""
SKINNED = DAE.replace("<library_visual_scenes>", SKIN).replace(
    INSTANCE, '<instance_controller url="#c"/>'
)
POLYGONS = SKINNED.replace("triangles", "polylist").replace("<p>", "<vcount>3 3</vcount><p>")


@pytest.mark.parametrize(
    "text, low, high, words",
    [
        (DAE.replace(' xmlns="http://www.collada.org/2005/11/COLLADASchema"', ""), 10, 11, ""),
        (DAE.replace('target="#ma"', 'target="#gone"'), 10, 11, ""),
        (SKINNED, 10, 11, ""),
        (POLYGONS, 15, 16, ""),
        (DAE.replace("</node>", f"</node><node id='m'>{INSTANCE}</node>"), 10, 11, "'g' are where"),
    ],
    ids=["no namespace", "no material", "skin", "skin of polygons", "two instances"],
)
def test_collada_is_read_as_gazebo_11_1_reads_it(tmp_path, text, low, high, words):
    """Measured there: MeshManager::Load of such files."""
    shapes, warnings = localised(tmp_path, "m.dae", text)
    assert len(warnings) == bool(words) and words in "".join(warnings)
    points = np.vstack([corners(shape) for shape in shapes]) / 0.0254
    assert points[:, 0].min() == pytest.approx(low, abs=1e-4)
    assert points[:, 0].max() == pytest.approx(high, abs=1e-4)


def test_the_parts_of_a_dae_have_the_names_of_their_nodes(tmp_path):
    """As ColladaLoader names submeshes. A visual has all of a name; a collision the first, and the
    whole mesh where there is none, as Gazebo 11.1 does it."""
    text = DAE.replace('<node id="n">', '<node id="n" name="Wheel">')
    for role, name, triangles in (
        ("visuals", "Wheel", 4),
        ("collisions", "Wheel", 2),
        ("collisions", "Whee", 4),
    ):
        shapes, warnings = localised(tmp_path, "m.dae", text, role, submesh=name)
        assert warnings == [] and sum(len(corners(s)) for s in shapes) == 3 * triangles
    _, (warning,) = localised(tmp_path, "m.dae", text, submesh="Whee")
    assert "no part 'Whee'; parts are Wheel" in warning


@pytest.mark.parametrize(
    "content",
    [
        binary_stl() + b"what follows the triangles",
        b"solid facet of a CAD".ljust(80) + binary_stl()[80:],
        ASCII_STL.replace("solid t", "solid Ger\xe4t").encode("latin-1"),
        "\n  " + ASCII_STL.upper().replace("\n", "\r\n\t"),
        ASCII_STL + ASCII_STL.replace("solid t", "solid u"),
    ],
    ids=["rest", "binary with solid", "Latin-1", "upper case", "two solids"],
)
@pytest.mark.parametrize("scale", [1.0, -1.0])
def test_stl_is_read_as_gazebo_11_1_reads_it(tmp_path, content, scale):
    path = tmp_path / "m.stl"
    path.write_bytes(content if isinstance(content, bytes) else content.encode("latin-1"))
    triangles = mesh_triangles(str(path))
    assert triangles is not None and {tuple(row) for row in triangles.reshape(-1, 3)} == set(
        TETRAHEDRON
    )
    shapes, warnings = localised(tmp_path, "m.stl", content, scale=(scale, 1.0, 1.0))
    assert len(shapes) == 1 and warnings == []


def test_same_content_is_converted_once(tmp_path):
    first, _ = localised(tmp_path, "a.stl", ASCII_STL)
    stamp = (tmp_path / "out" / "meshes").stat().st_mtime_ns
    again, _ = localised(tmp_path, "a.stl", ASCII_STL)
    assert first[0].geometry.path == again[0].geometry.path
    assert (tmp_path / "out" / "meshes").stat().st_mtime_ns == stamp


def test_a_box_keeps_its_image_and_a_ball_gets_its_mean(tmp_path):
    Image.new("RGB", (30, 21), (10, 200, 30)).save(tmp_path / "p.png")
    link = Link(
        "l",
        visuals=[
            Shape(Geometry("box", (2, 4, 0.1)), texture=str(tmp_path / "p.png")),
            Shape(Geometry("sphere", (1,)), texture=str(tmp_path / "p.png")),
        ],
    )
    prepare_meshes(LumpedModel({"l": link}, (), "l", {}), str(tmp_path), lambda text: None)
    box, ball = link.visuals
    assert ball.color == pytest.approx((10 / 255, 200 / 255, 30 / 255, 1), abs=0.01)
    np.testing.assert_allclose(np.ptp(corners(box), axis=0), (2, 4, 0.1))
    saved = list((tmp_path / "meshes").glob("*/*.png"))
    assert len(saved) == 1
    with Image.open(saved[0]) as image:
        assert image.size == (30, 21)


def test_static_mesh_is_hollow_and_a_moving_one_a_hull(tmp_path):
    """A ring wall: a ray through its hole meets nothing when it is static."""
    path = tmp_path / "ring.stl"
    frame = ""
    inner, outer = [(1, 1), (-1, 1), (-1, -1), (1, -1)], [(2, 2), (-2, 2), (-2, -2), (2, -2)]
    for k in range(4):
        a, b, c, d = inner[k], inner[(k + 1) % 4], outer[(k + 1) % 4], outer[k]
        for triangle in ((a, c, b), (a, d, c)):
            frame += (
                "facet normal 0 0 1\nouter loop\n"
                + "".join(f"vertex {x} {y} 0\n" for x, y in triangle)
                + "endloop\nendfacet\n"
            )
    path.write_text(f"solid r\n{frame}endsolid r\n")
    text = (
        '<model name="ring"><static>{}</static><link name="l"><collision name="c"><geometry>'
        f"<mesh><uri>{path}</uri></mesh></geometry></collision></link></model>"
    )
    hits = {}
    for static in ("true", "false"):
        world = World(solver="bullet")
        model, _ = sdf.parse_model(text.format(static), str)
        world.spawn(model, Pose((0.0, 0.0, 1.0)))
        down, centers = np.array([(0.0, 0.0, -1.0)]), np.array([(0.1, 0.2, 5.0), (1.5, 0.0, 5.0)])
        ranges = [world.engine.cast_rays(Rays(center, down, 0.0, 10.0))[0] for center in centers]
        hits[static] = np.isfinite(ranges).tolist()
        world.close()
    assert hits == {"true": [False, True], "false": [True, True]}


@pytest.mark.parametrize(
    "name, place",
    [
        ("green.png", "green.png"),
        ("pictures/green.png", "pictures/green.png"),
        ("../materials/textures/green.png", "../materials/textures/green.png"),
        ("green.png", "../materials/textures/green.png"),
        ("C:\\Users\\me\\green.png", "../materials/textures/green.png"),
        ("file:///home/me/green%20leaf.png", "green leaf.png"),
    ],
)
def test_images_are_found_where_gazebo_models_have_them(tmp_path, name, place):
    folder = tmp_path / "meshes"
    folder.mkdir()
    file = folder / place
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(b"image")
    assert MeshFileResolver(str(folder / "m.dae")).get(name) == b"image"
    with pytest.raises(FileNotFoundError, match="red.png"):
        MeshFileResolver(str(folder / "m.dae")).get("red.png")


def test_a_dae_whose_image_is_missing_is_told(tmp_path):
    """It is white then, and looks as if it were meant to be."""
    image = (
        '<library_images><image id="i"><init_from>wood.png</init_from></image></library_images>'
        "<library_effects>"
    )
    color = "<lambert><diffuse><color>1 0 0 1</color></diffuse></lambert></technique>"
    parameters = (
        '<newparam sid="u"><surface type="2D"><init_from>i</init_from></surface></newparam>'
        '<newparam sid="t"><sampler2D><source>u</source></sampler2D></newparam>'
    )
    texture = (
        '<lambert><diffuse><texture texture="t" texcoord="x"/></diffuse></lambert></technique>'
    )
    text = DAE.replace("<library_effects>", image).replace(color, texture, 1)
    text = text.replace("<profile_COMMON>", f"<profile_COMMON>{parameters}", 1)
    _, (warning,) = localised(tmp_path, "m.dae", text)
    assert "m.dae': an image is left out" in warning and "'wood.png' is neither in" in warning
