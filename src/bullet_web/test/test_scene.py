"""Scenes for browsers: the meshes, images, colors and places that the camera renderer has."""

import io
import json
from dataclasses import asdict

import numpy as np
import pytest
from bullet_sim.description.model import Finish, Geometry, Layer, Shape, TextureMapping
from bullet_sim.meshes.solids import solid
from bullet_sim.pose import Pose
from bullet_sim.sensors.scenes import WorldViews
from bullet_sim.world import World
from bullet_web.scene import SceneMaker, image_asset, shape_of
from PIL import Image
from replay_rig import ARM

PLANE = """<sdf version="1.6"><model name="{name}"><static>true</static><link name="l">
  <visual name="v"><geometry><mesh><uri>{path}</uri></mesh></geometry></visual>
</link></model></sdf>"""


@pytest.fixture
def world():
    made = World()
    yield made
    made.close()


def scene_of(world, maker=None):
    """Scene and maker of a world, through JSON as from the simulator."""
    maker = maker or SceneMaker()
    return maker.make(json.loads(json.dumps(WorldViews(world).scene()))), maker


def written_plane(folder, color=(10, 200, 30)):
    """A square with a texture, as OBJ file."""
    Image.new("RGB", (8, 4), color).save(folder / "paint.png")
    (folder / "plane.mtl").write_text("newmtl paint\nmap_Kd paint.png\n")
    path = folder / "plane.obj"
    path.write_text(
        "mtllib plane.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
    )
    return path


def test_bodies_have_links_joints_and_instances(world):
    world.spawn_urdf("arm", ARM, Pose((1.0, 2.0, 3.0)), str)
    scene, maker = scene_of(world)
    (body,) = scene["bodies"]
    assert (body["name"], body["static"], body["state"][1:4]) == ("arm", False, [1.0, 2.0, 3.0])
    base, wheel = body["links"]
    assert (base["parent"], wheel["parent"], wheel["joint"], wheel["axis"]) == (
        -1,
        0,
        "axle",
        [0.0, 1.0, 0.0],
    )
    assert body["frames"]["plate"] == [0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0]
    box, ball = base["instances"]
    assert box["color"] == [1.0, 0.0, 0.0, 1.0]
    assert np.reshape(box["matrix"], (4, 4)).T[:3, :3] == pytest.approx(np.diag([0.2, 0.4, 0.6]))
    assert ball["transparent"] and ball["color"][3] == 0.5
    assert np.reshape(ball["matrix"], (4, 4)).T[:3, 3] == pytest.approx([0.0, 0.0, 0.4])
    assert scene["problems"] == []


def test_a_mesh_holds_its_corners_and_triangles(world):
    world.spawn_urdf("arm", ARM, Pose(), str)
    scene, maker = scene_of(world)
    data = maker.assets[scene["bodies"][0]["links"][0]["instances"][0]["mesh"]].data
    corners, triangles = solid("box")
    (count,) = np.frombuffer(data, "<u4", 1)
    assert count == len(corners)
    assert np.array_equal(np.frombuffer(data, "<f4", 8 * count, 4).reshape(-1, 8), corners)
    assert np.array_equal(
        np.frombuffer(data, "<u4", offset=4 + 32 * count).reshape(-1, 3), triangles
    )


def test_a_textured_mesh_brings_its_image(world, tmp_path):
    path = written_plane(tmp_path)
    world.spawn_sdf("plane", PLANE.format(name="plane", path=path), Pose(), str)
    scene, maker = scene_of(world)
    (instance,) = scene["bodies"][0]["links"][0]["instances"]
    asset = maker.assets[instance["image"]]
    assert asset.type == "image/jpeg"
    image = Image.open(io.BytesIO(asset.data))
    assert image.size == (8, 4)
    assert np.abs(np.subtract(image.getpixel((3, 2)), (10, 200, 30))).max() < 8


def test_a_visual_with_images_of_its_material_brings_the_lowest(tmp_path):
    path = str(tmp_path / "red.png")
    Image.new("RGB", (8, 8), (250, 0, 0)).save(path)
    mapping = TextureMapping((2.0, 0.0, 0.0, 0.0, 2.0, 0.0))
    shape = Shape(
        Geometry("box", (1.0, 1.0, 1.0)),
        texture=path,
        painted=True,
        finish=Finish(mapping=mapping, layers=(Layer(path, "add", mapping),)),
    )
    read = shape_of(json.loads(json.dumps(asdict(shape))))
    assert read.finish.mapping == mapping and read.finish.layers == ()
    links = [{"shapes": [json.loads(json.dumps(asdict(shape)))]}]
    maker = SceneMaker()
    scene = maker.make({"bodies": [{"name": "m", "links": links}]})
    (instance,) = scene["bodies"][0]["links"][0]["instances"]
    assert instance["image"] in maker.assets and scene["problems"] == []


def test_images_keep_their_upper_side_and_their_transparency():
    rows = np.zeros((2, 2, 4), np.uint8)
    rows[0] = (255, 0, 0, 255)  # OpenGL's first row is the lowest
    rows[1] = (0, 0, 255, 100)
    asset = image_asset((2, 2), 4, rows.tobytes())
    image = Image.open(io.BytesIO(asset.data))
    assert asset.type == "image/png"
    assert image.getpixel((0, 0)) == (0, 0, 255, 100)
    assert image.getpixel((0, 1)) == (255, 0, 0, 255)


def test_what_cannot_be_read_is_a_problem_and_the_rest_is_there(world, tmp_path):
    world.spawn_urdf("arm", ARM, Pose(), str)
    path = written_plane(tmp_path)
    world.spawn_sdf("plane", PLANE.format(name="plane", path=path), Pose(), str)
    source = json.loads(json.dumps(WorldViews(world).scene()))
    for body in source["bodies"]:
        for link in body["links"]:
            for shape in link["shapes"]:
                if shape["geometry"]["kind"] == "mesh":
                    shape["geometry"]["path"] = str(tmp_path / "gone.obj")
    scene = SceneMaker().make(source)
    assert len(scene["problems"]) == 1 and scene["problems"][0].startswith("plane: ")
    assert "gone.obj" in scene["problems"][0]
    assert len(scene["bodies"][0]["links"][0]["instances"]) == 2


def test_names_of_assets_stay_and_unused_ones_go(world, tmp_path):
    path = written_plane(tmp_path)
    world.spawn_sdf("plane", PLANE.format(name="plane", path=path), Pose(), str)
    views, maker = WorldViews(world), SceneMaker()
    maker.make(views.scene())
    first = set(maker.assets)
    world.spawn_urdf("arm", ARM, Pose(), str)
    maker.make(views.scene())
    assert first < set(maker.assets)
    world.delete("plane")
    maker.make(views.scene())
    assert not first & set(maker.assets)


def test_lights_and_background_are_the_world_s(world):
    scene, _ = scene_of(world)
    assert scene["light"]["lights"][0]["name"] == "sun"
    assert scene["light"]["background"] == [0.7, 0.7, 0.7]  # Gazebo's, of a world without <sky>
    assert all(0.0 <= value <= 1.0 for color in scene["sky"] for value in color)


def test_a_heightmap_is_a_mesh_with_its_first_texture(world, tmp_path):
    gray = np.tile(np.linspace(0, 255, 9).astype(np.uint8), (9, 1))
    Image.fromarray(gray).save(tmp_path / "land.png")
    Image.new("RGB", (8, 4), (10, 200, 30)).save(tmp_path / "paint.png")
    shape = (
        f"<heightmap><uri>{tmp_path}/land.png</uri><size>4 4 1</size><sampling>1</sampling>"
        f"<texture><diffuse>{tmp_path}/paint.png</diffuse><size>2</size></texture></heightmap>"
    )
    text = f"<link name='l'><visual name='v'><geometry>{shape}</geometry></visual></link>"
    text = f"<sdf version='1.6'><model name='m'><static>1</static>{text}</model></sdf>"
    assert world.spawn_sdf("m", text, Pose(), str).description.warnings == []
    scene, maker = scene_of(world)
    assert len(scene["bodies"]) == 1
    types = {asset.type for asset in maker.assets.values()}
    assert any(kind.startswith("image/") for kind in types), types
    sizes = [len(a.data) for a in maker.assets.values() if "octet" in a.type]
    assert sizes == [4 + 81 * 32 + 128 * 12]
