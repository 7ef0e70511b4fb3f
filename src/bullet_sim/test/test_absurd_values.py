"""Numbers and texts of files that nothing can be computed of: one bad element costs itself."""

import pytest
from bullet_sim.errors import ModelError
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.formats.urdf import parse_urdf


def world_of(sensor_type, content, plugin, tags):
    link = (
        f'<link name="l"><sensor name="s" type="{sensor_type}">{content}'
        f'<plugin name="p" filename="lib{plugin}.so">{tags}</plugin></sensor></link>'
    )
    return f'<sdf version="1.6"><world name="w"><model name="m">{link}</model></world></sdf>'


SCAN = "<samples>9</samples><resolution>1e308</resolution>"
SCAN = f"<ray><scan><horizontal>{SCAN}</horizontal></scan></ray>"


@pytest.mark.parametrize(
    "text",
    [
        world_of("ray", SCAN, "gazebo_ros_laser", ""),
        world_of(
            "imu",
            "",
            "gazebo_ros_imu_sensor",
            "<frameName>f</frameName><gaussianNoise>1e308</gaussianNoise>",
        ),
        world_of(
            "imu",
            "",
            "gazebo_ros_imu_sensor",
            "<frameName>f</frameName><updateRateHZ>1e-320</updateRateHZ>",
        ),
    ],
    ids=["resolution", "noise", "rate"],
)
def test_a_sensor_with_absurd_numbers_is_left_out_or_read(text):
    """Each was a traceback at the start."""
    described = parse_world(text, str, "file.world")
    assert len(described.models) == 1
    for warning in described.warnings:
        assert "file.world, line 1" in warning or "sensor" in warning


@pytest.mark.parametrize("name", ["quopri", "zlib", "bz2", "rot13", "undefined", "punycode", "x"])
def test_an_encoding_is_one_of_texts(name):
    """Python has others, which are none, and decode bytes to bytes."""
    text = f'<?xml version="1.0" encoding="{name}"?><sdf version="1.6"><world name="w"/></sdf>'
    assert parse_world(text.encode(), str, "file.world").name == "w"


@pytest.mark.parametrize("parse", [parse_world, parse_model, parse_urdf])
@pytest.mark.parametrize("error", [OverflowError, TypeError, RecursionError, MemoryError, OSError])
def test_what_a_reader_raises_is_an_error_with_the_file(parse, error):
    def resolve(_):
        raise error("absurd")

    shape = "<geometry><mesh filename='a'><uri>a</uri></mesh></geometry>"
    model = f"<link name='l'><visual name='v'>{shape}</visual></link>"
    text = f"<robot name='m'>{model}</robot>"
    if parse is not parse_urdf:
        text = f"<sdf><world name='w'><model name='m'>{model}</model></world></sdf>"
    try:
        parse(text, resolve, "the file")
    except ModelError as problem:
        assert "the file" in str(problem) and "absurd" in str(problem)
