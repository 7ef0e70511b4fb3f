"""Worlds and models of SDF with bad parts: each costs itself and one warning, never the world."""

import pytest
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.pose import Pose
from bullet_sim.world import World
from sdf_texts import FALLEN, MASS, NAN_INERTIA, fallen, model, read, weighing, world_of

LINK = f'<link name="a">{MASS}</link>'
FIXED = '<joint name="j" type="fixed"><parent>a</parent><child>b</child></joint>'
TWO = f'{LINK}<link name="b"><pose>0 0 1 0 0 0</pose>{MASS}</link>'
AGAIN = '<joint name="k" type="fixed"><parent>b</parent><child>a</child></joint>'
SECOND = FIXED.replace(">b<", ">c<")
CIRCLE = (
    '<link name="a"><pose relative_to="b">0 0 0 0 0 0</pose></link>'
    '<link name="b"><pose relative_to="a">0 0 0 0 0 0</pose></link>'
)

# what is wrong: what the model holds, its links and joints, words of the one warning
PARTS = {
    "no link": ("<static>1</static>", None, None, ["model 'm' is left out", "has no link"]),
    "two links of one name": (
        LINK + LINK + FIXED.replace(">b<", ">a_1<"),
        "a a_1",
        "j",
        ["link 'a'", "'a_1'"],
    ),
    "two joints of one name": (
        f'{TWO}<link name="c"/>{FIXED}{SECOND}',
        "a b c",
        "j j_1",
        ["joint 'j'", "'j_1'"],
    ),
    "a joint without ends": (f'{LINK}<joint name="j" type="fixed"/>', "a", "", ["joins 'None'"]),
    "no such link": (LINK + FIXED, "a", "", ["'b'", "links are a", "left out"]),
    "two joints of one pair": (TWO + FIXED + AGAIN, "a b", "j k", []),
    "a joint to itself": (
        TWO + FIXED + AGAIN.replace(">a<", ">b<"),
        "a b",
        "j",
        ["joint 'k'", "joins 'b' to itself"],
    ),
    "a free link": (TWO, "a b", "", []),
    "an unknown tag": (LINK + "<glitter/>", "a", "", ["<glitter>"]),
    "a tag in capitals": (LINK + "<Link name='x'/>", "a", "", ["<Link>"]),
    "prefixes": (LINK + "<drake:gain>1</drake:gain>", "a", "", []),
    "an include that is missing": (
        LINK + "<include><uri>model://gone</uri></include>",
        "a",
        "",
        ["model://gone", "nowhere"],
    ),
    "a sensor of an unknown type": (
        LINK.replace("</link>", '<sensor name="s" type="smell"/></link>'),
        "a",
        "",
        ["'smell'"],
    ),
    "frames in a circle": (
        '<link name="a"><pose relative_to="b">0 0 0 0 0 0</pose></link>'
        f'<link name="b"><pose relative_to="a">0 0 0 0 0 0</pose></link>{FIXED}',
        "a b",
        "j",
        ["circle", "a, b"],
    ),
}


@pytest.mark.parametrize("text, links, joints, words", PARTS.values(), ids=PARTS)
def test_a_bad_part_costs_itself(text, links, joints, words):
    world = world_of(f'<model name="m"><pose>0 0 1 0 0 0</pose>{text}</model>')
    assert len(world.warnings) == (1 if words else 0), world.warnings
    for word in words:
        assert word in world.warnings[0]
    names = [found.name for found, _ in world.models]
    if links is None:
        assert names == ["ground_plane", "sound"]
    else:
        assert names == ["ground_plane", "sound", "m"]
        assert list(read(world).links) == links.split()
        assert list(read(world).joints) == joints.split()


ENDS = {
    "NaN inertia with mass 0": weighing("<mass>0</mass>", NAN_INERTIA),
    "NaN inertia": weighing(inertia=NAN_INERTIA),
    "masses and inertias of 0": weighing("<mass>0</mass>", NAN_INERTIA.replace("nan", "0")),
    "a negative inertia": weighing(inertia=NAN_INERTIA.replace("nan", "-1")),
    "an inertia beyond numbers": weighing(
        "<mass>1e300</mass>", NAN_INERTIA.replace("nan", "1e308")
    ),
    "a model nowhere": model(pose="1e300 0 0 0 0 0"),
    "a model without a name": model().replace('name="m"', 'name=""'),
    "two models of one name": model() + model(pose="0 0 3 0 0 0"),
    "a model of the floor's name": model(pose="9 0 3 0 0 0").replace('"m"', '"ground_plane"'),
}


@pytest.mark.parametrize("text", ENDS.values(), ids=ENDS)
def test_no_value_ends_the_world(text):
    assert fallen(text) == pytest.approx(FALLEN, abs=0.01)


def test_what_is_left_runs():
    """All of it in one world; the models touch nothing and fall side by side."""
    texts = [f'<model name="m"><pose>0 0 1 0 0 0</pose>{row[0]}</model>' for row in PARTS.values()]
    assert fallen("".join(texts)) == pytest.approx(FALLEN, abs=0.01)


def test_a_model_that_cannot_be_placed_is_one_warning():
    world = World()
    try:
        (warning,) = world.load(world_of(model(pose="1e300 0 0 0 0 0")))
        assert "'m'" in warning and "1e+300" in warning and "left out" in warning
        assert list(world.models) == ["ground_plane", "sound"]
        world.reset()
    finally:
        world.close()


@pytest.mark.parametrize(
    "version, of_model",
    [("1.4", True), ("1.5", False), ("1.10", False), ("2", False), ("new", False), ("", False)],
)
def test_versions(version, of_model):
    """Up to 1.4 axes are in the model's frame; what is unknown counts as new."""
    text = '<link name="a"/><link name="b"><pose>0 0 0 0 0 1.5707963267948966</pose></link>'
    text += '<joint name="j" type="revolute"><parent>a</parent><child>b</child>'
    text += "<axis><xyz>1 0 0</xyz></axis></joint>"
    found, _ = parse_model(f'<sdf version="{version}"><model name="m">{text}</model></sdf>', str)
    assert found.joints["j"].axis == pytest.approx((0, -1, 0) if of_model else (1, 0, 0), abs=1e-9)


@pytest.mark.parametrize("light", ["point", "spot"])
def test_included_lights_are_quiet(tmp_path, light):
    path = tmp_path / "model.sdf"
    path.write_text(f'<sdf version="1.6"><light name="l" type="{light}"/></sdf>')
    text = f'<sdf version="1.6"><world name="w"><include><uri>{path}</uri></include></world></sdf>'
    world = parse_world(text, str, "w")
    assert world.warnings == [] and world.models == []


def test_an_included_file_names_itself(tmp_path):
    path = tmp_path / "model.sdf"
    path.write_text(f'<sdf version="1.6">\n{model(pose="1 2 3 0 0")}</sdf>')
    include = f"<include><uri>{path}</uri></include>"
    text = f'<sdf version="1.6"><world name="w">{include}{include}</world></sdf>'
    world = parse_world(text, str, "w")
    assert [pose for _, pose in world.models] == [Pose((1.0, 2.0, 3.0))] * 2
    assert len([text for text in world.warnings if f"{path}, line 2" in text]) == 1


@pytest.mark.parametrize("uri", ["meshes/m.stl", "./meshes/m.stl", "../tree/meshes/m.stl"])
def test_meshes_beside_their_file(tmp_path, uri):
    (tmp_path / "tree" / "meshes").mkdir(parents=True)
    (tmp_path / "tree" / "meshes" / "m.stl").write_bytes(b"")
    visual = f'<visual name="v"><geometry><mesh><uri>{uri}</uri></mesh></geometry></visual>'
    (tmp_path / "tree" / "model.sdf").write_text(f'<sdf version="1.6">{model(link=visual)}</sdf>')
    include = f"<include><uri>{tmp_path}/tree/model.sdf</uri></include>"
    world = parse_world(f'<sdf version="1.6"><world name="w">{include}</world></sdf>', str, "w")
    (shape,) = read(world).links["a"].visuals
    assert shape.geometry.path == str(tmp_path / "tree" / "meshes" / "m.stl")


def test_materials_without_a_script_file(tmp_path):
    (tmp_path / "p.material").write_text(
        "material Mine\n{\ntechnique\n{\npass\n{\ndiffuse 0 1 0 1\n}\n}\n}\n"
    )

    def resolve(uri):
        if uri != "file://media/materials/scripts":
            raise ValueError("nowhere")
        return str(tmp_path)

    material = "<material><script><name>Mine</name></script></material>"
    visual = f'<visual name="v"><geometry><sphere/></geometry>{material}</visual>'
    text = f'<sdf version="1.6">{model(link=visual)}</sdf>'
    described, _ = parse_model(text, resolve)
    assert described.links["a"].visuals[0].color == (0, 1, 0, 1) and described.warnings == []
