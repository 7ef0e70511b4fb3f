"""Files that are broken on purpose: a sentence that names the file, in little time and memory."""

import os
import resource
import struct
import zipfile
import zlib

import collada  # noqa: F401  # here, so that no child takes the time
import pytest
import trimesh  # noqa: F401
from bullet_sim.errors import ModelError, SimError
from bullet_sim.files import LIMITS
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.meshes import prepare, terrain
from bullet_sim.meshes.read import open_image
from bullet_sim.pose import Pose
from bullet_sim.world import World
from bullet_sim.xml_reader import MAX_DEPTH, parse
from hypothesis import given, seed, settings
from hypothesis import strategies as st
from urdf_texts import inertial

pytestmark = pytest.mark.isolated  # it forks

MAX_MEMORY = 500_000_000  # [bytes] of memory that one file may cost
LONGEST = 30.0  # [s] of CPU time: 2 s on the machines that this was measured on
FEW = settings(derandomize=True, deadline=None, max_examples=60, database=None)
URDF = (
    f'<robot name="r"><link name="a">{inertial()}<visual><geometry>{{}}</geometry></visual>'
    "<collision><geometry>{}</geometry></collision></link></robot>"
)


def in_a_child(work):
    """Run work() in a child process with bounded memory and CPU time.

    Returns:
        What it returned or the SimError that it raised, as text.
    """
    source, target = os.pipe()
    child = os.fork()
    if child == 0:
        with open("/proc/self/statm", encoding="ascii") as file:
            now = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (now + MAX_MEMORY, now + MAX_MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        try:
            text = str(work())
        except SimError as error:
            text = str(error)
        except BaseException as error:  # said in the parent
            text = f"CRASH {type(error).__name__}: {error}"
        os.write(target, text.encode()[:60000])
        os._exit(0)
    os.close(target)
    with os.fdopen(source, "rb") as stream:
        text = stream.read().decode()
    _, status, used = os.wait4(child, 0)
    assert os.WIFEXITED(status) and not text.startswith("CRASH"), (status, text)
    assert used.ru_utime + used.ru_stime < LONGEST
    return text


def warnings_of(text):
    """Spawn URDF text; returns what is said about it."""
    world = World()
    model = world.spawn_urdf("m", text, Pose(), str)
    world.step(2)
    world.close()
    return "; ".join(map(str, model.description.warnings))


def with_mesh(path):
    """URDF text of a link that is a mesh."""
    shape = f'<mesh filename="{path}"/>'
    return URDF.format(shape, shape)


def png(width, height):
    """A PNG that says to have so many pixels, and has fewer."""

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    rows = zlib.compress(b"\0" * 300)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    )


# XML ----------------------------------------------------------------------------------------------
LAUGHS = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12))
BOMB = f'<?xml version="1.0"?><!DOCTYPE r [<!ENTITY l0 "lol">{LAUGHS}]>'


@pytest.mark.parametrize(
    "text",
    [
        BOMB + '<robot name="r"><link name="a">&l11;</link></robot>',
        "<!DOCTYPE r [<!ENTITY a '" + "a" * 100_000 + "'>]><robot>" + "&a;" * 20_000 + "</robot>",
        "<a>" * 100_000,
        "<a b='" * 50_000,
        "<" * 300_000,
        "<robot>" + "<!--" * 100_000,
        "<robot>" + "<![CDATA[" * 50_000 + ">",
        "<robot " + "a" * 200_000 + ">",
        "<robot>" + "&" * 300_000 + "</robot>",
        '<robot a="' + "'<>" * 100_000,
    ],
    ids=lambda text: text[:20],
)
def test_xml_takes_time_in_proportion_to_its_length(text):
    assert in_a_child(lambda: parse_urdf(text, str, "bomb.urdf")) is not None


def test_an_external_entity_is_not_read(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("TOP SECRET")
    head = f'<!DOCTYPE r [<!ENTITY x SYSTEM "{secret.as_uri()}">]>'
    for text in (head + "<a><b>&x;</b></a>", head + '<a><b c="&x;"/></a>'):
        said = in_a_child(lambda: [(e.text, dict(e.attrib)) for e in parse(text, "x.urdf").iter()])
        assert "SECRET" not in said


def test_nesting_is_bounded():
    def nested(depth):
        return "<a>" * depth + "</a>" * depth

    assert parse(nested(MAX_DEPTH), "x.urdf").tag == "a"
    with pytest.raises(ModelError, match="x.urdf has more than 100 nested elements"):
        parse(nested(MAX_DEPTH + 1), "x.urdf")
    models = "<model name='m'>" * 5000 + "</model>" * 5000
    said = in_a_child(lambda: sdf.parse_world(f"<sdf><world>{models}</world></sdf>", str))
    assert "nested elements" in said


# meshes -------------------------------------------------------------------------------------------
def stl(count, triangles):
    """A binary STL that says to have `count` triangles and has others."""
    return b"x" * 80 + struct.pack("<I", count) + triangles


ROOM = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"


@pytest.mark.parametrize(
    "name, content",
    [
        ("count.stl", stl(2**32 - 1, b"\0" * 150)),
        ("none.stl", stl(0, b"")),
        ("far.stl", stl(4, struct.pack("<12fH", *[3e38] * 12, 0) * 4)),
        ("open.stl", b"solid " + b"facet normal 0 0 0\n" * 1000),
        ("corner.obj", ROOM.encode() + b"f 1 2 99999999999999999999\n"),
        ("empty.obj", b"\n" * 1_000_000),
        ("blank.obj", b" " * 1_000_000),
        ("bomb.dae", BOMB.encode() + b"<COLLADA>&l11;</COLLADA>"),
        ("deep.dae", b"<COLLADA>" + b"<node>" * 20_000),
        ("cut.dae", b"<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema'>"),
        ("none.dae", b""),
    ],
)
def test_a_broken_mesh_is_left_out_by_name(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    assert str(path) in in_a_child(lambda: warnings_of(with_mesh(path)))


def test_a_mesh_that_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "pipe.stl")
    for path in (tmp_path / "pipe.stl", "/dev/zero", tmp_path):
        said = in_a_child(lambda path=path: warnings_of(with_mesh(path)))
        assert str(path) in said


def test_a_dae_reads_no_other_file_by_an_entity(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("TOP SECRET")
    path = tmp_path / "x.dae"
    path.write_text(f'<!DOCTYPE r [<!ENTITY x SYSTEM "{secret.as_uri()}">]><COLLADA>&x;</COLLADA>')
    said = in_a_child(lambda: warnings_of(with_mesh(path)))
    assert str(path) in said and "SECRET" not in said


@seed(1)
@FEW
@given(st.binary(max_size=400) | st.text("v fn/0123.-e\n", max_size=200).map(str.encode))
def test_any_bytes_are_a_mesh_or_an_error(data):
    for name in ("m.stl", "m.obj"):
        error = prepare.mesh_error(name, prepare.mesh_type(name, data), data)
        assert error == "" or name in error


# images -------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "content",
    [png(16384, 16384), png(2**31 - 4, 2**31 - 4), png(1, 1)[:40], png(64, 64), b"", b"no image"],
    ids=["16k", "2 G", "cut in its head", "cut in its rows", "empty", "text"],
)
def test_a_broken_image_is_named(tmp_path, content):
    path = tmp_path / "p.png"
    path.write_bytes(content)
    assert str(path) in in_a_child(lambda: open_image(str(path)))
    land = f"<heightmap><uri>{path}</uri><size>10 10 1</size></heightmap>"
    text = (
        '<sdf version="1.6"><model name="h"><static>true</static><link name="l"><collision '
        f'name="c"><geometry>{land}</geometry></collision></link></model></sdf>'
    )

    def spawn():
        world = World()
        model = world.spawn_sdf("h", text, Pose(), str)
        return list(map(str, model.description.warnings))

    assert str(path) in in_a_child(spawn)


def test_an_image_of_too_many_pixels_next_to_a_mesh_is_left_out(tmp_path):
    (tmp_path / "p.png").write_bytes(png(16384, 16384))
    (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd p.png\n")
    path = tmp_path / "m.obj"
    path.write_text("mtllib m.mtl\nusemtl a\n" + ROOM + "f 1/1/1 2/1/1 3/1/1\n")
    said = in_a_child(lambda: warnings_of(with_mesh(path)))
    assert str(tmp_path / "p.png") in said and str(LIMITS["image_pixels"]) in said


def test_an_image_of_one_pixel(tmp_path):
    from PIL import Image

    Image.new("RGB", (1, 1), (255, 0, 0)).save(tmp_path / "one.png")
    assert open_image(str(tmp_path / "one.png")).size == (1, 1)


def with_heightmap(path):
    """SDF text of a static model whose ground is an image."""
    shape = f"<geometry><heightmap><uri>{path}</uri><size>9 9 1</size></heightmap></geometry>"
    link = f'<link name="l"><collision name="c">{shape}</collision></link>'
    return f'<sdf version="1.6"><model name="m"><static>1</static>{link}</model></sdf>'


def test_a_collada_file_that_is_a_zip_is_not_unpacked(tmp_path):
    """3 MB became 6 GB."""
    path = tmp_path / "mesh.dae"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        with file.open("mesh.dae", "w", force_zip64=True) as inner:
            for _ in range(900):
                inner.write(b" " * (1 << 20))
    text = in_a_child(lambda: warnings_of(with_mesh(path)))
    assert f"mesh '{path}' cannot be read" in text and "it is a ZIP" in text


def test_a_material_library_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text("mtllib sparse.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with open(tmp_path / "sparse.mtl", "wb") as file:
        file.truncate(6 << 30)
    text = in_a_child(lambda: warnings_of(with_mesh(path)))
    assert "sparse.mtl' has 6442450944 bytes, must have at most 20000000" in text


def test_the_largest_heightmap_costs_little_memory(tmp_path):
    """8192 x 8192 numbers of 16 bits took 1.4 GB; the pixels alone are 268 MB."""
    path, packer = tmp_path / "land.png", zlib.compressobj(9)
    rows = b"".join(packer.compress(b"\0" + b"\x80" * 16384) for _ in range(8192))
    head = struct.pack(">IIBBBBB", 8192, 8192, 16, 0, 0, 0, 0)
    parts = ((b"IHDR", head), (b"IDAT", rows + packer.flush()), (b"IEND", b""))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in parts
        )
    )

    def corners():
        vertices, _ = terrain.heightmap(str(path), (9.0, 9.0, 1.0))
        return len(vertices), vertices[:, 2].min()

    assert in_a_child(corners) == "(263169, 1.0)"


@pytest.mark.parametrize("use", [with_mesh, with_heightmap])
def test_a_pipe_is_refused_at_once(tmp_path, use):
    """Reading one waits for ever."""
    os.mkfifo(tmp_path / "pipe.stl")
    path = tmp_path / "pipe.stl"

    def spawn():
        world = World()
        text = use(path)
        kind = world.spawn_urdf if use is with_mesh else world.spawn_sdf
        return "; ".join(map(str, kind("m", text, Pose(), str).description.warnings))

    text = in_a_child(spawn)
    assert str(path) in text and ("does not exist" in text or "is not found" in text)
