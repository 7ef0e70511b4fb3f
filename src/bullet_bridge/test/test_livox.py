"""The clouds of livox_laser_simulation, without a ROS master."""

import gzip
import math
import os

import numpy as np
import pytest
from bullet_bridge.plugins import lidars
from bullet_sim.errors import ModelError
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from fake_impl import plugin_of
from sensor_msgs.msg import PointCloud, PointCloud2
from urdf_texts import link

GRAVITY = (0.0, 0.0, 0.0)

WALL = (
    '<model name="w"><static>true</static><link name="l"><collision name="c"><laser_retro>9'
    "</laser_retro><geometry><box><size>0.2 20 20</size></box></geometry></collision></link>"
    "</model>"
)
PATTERN = "Time/s,Azimuth/deg,Zenith/deg\n0,0,90\n0.1,10,90\n0.2,0,80\n0.3,0,95\n0.4,50,90\n"


def robot(path, **values):
    tags = {"samples": 3, "downsample": 1, "csv_file_name": path, "ros_topic": "scan", **values}
    inner = "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items() if text is not None)
    axes = "".join(
        f"<{axis}><samples>{rows}</samples><min_angle>-{wide}</min_angle><max_angle>{wide}"
        f"</max_angle></{axis}>"
        for axis, rows, wide in (("horizontal", 100, 0.6), ("vertical", 50, 0.6))
    )
    return (
        f'<robot name="r">{link("base", 2, 1)}<gazebo reference="base">'
        '<sensor type="ray" name="livox"><pose>'
        "0 0 0.5 0 0 0</pose><update_rate>10</update_rate><plugin name='p' "
        f"filename='liblivox_laser_simulation.so'><ray><scan>{axes}</scan><range><min>0.1</min>"
        "<max>"
        f"50</max></range></ray>{inner}</plugin></sensor></gazebo></robot>"
    )


@pytest.fixture(name="pattern")
def _pattern(tmp_path):
    path = tmp_path / "pattern.csv"
    path.write_text(PATTERN, encoding="utf-8")
    return path


@pytest.fixture(name="world")
def _world(world):
    world.spawn_sdf("wall", WALL, Pose((5.1, 0.0, 0.0)), str)
    return world


def plugin(world, text):
    model = world.spawn_urdf("r", text, Pose(), str)
    (spec,) = model.description.sensors
    return plugin_of(world, model, spec)


def test_each_scan_has_the_next_rays_of_the_pattern(topics, world, pattern):
    made = plugin(world, robot(pattern))
    made.update(0.1, 0.1)
    made.update(0.2, 0.1)
    one, two = topics["/scan"].messages
    assert topics["/scan"].kind is PointCloud
    assert (one.header.frame_id, one.header.stamp.to_sec()) == ("livox", 0.1)
    found = [[(point.x, point.y, point.z) for point in scan.points] for scan in (one, two)]
    up = math.radians(10)  # a zenith of 80 degrees; as upstream ranges are longer by the minimum
    assert np.array(found[0]) == pytest.approx(np.array([
        (5.1, 0.0, 0.0),
        ((5.0 / math.cos(up) + 0.1) * math.cos(up), (5.0 / math.cos(up) + 0.1) * math.sin(up), 0.0),
        ((5.0 / math.cos(up) + 0.1) * math.cos(up), 0.0, (5.0 / math.cos(up) + 0.1) * math.sin(up)),
    ]), abs=1e-5)  # fmt: skip
    down = math.radians(5)  # 50 degrees to the side are outside of the field; then from the start
    assert [point[2] < 0 for point in found[1]] == [True, False]
    assert found[1][0][2] == pytest.approx(-(5.0 / math.cos(down) + 0.1) * math.sin(down), abs=1e-5)
    assert found[1][1] == pytest.approx((5.1, 0.0, 0.0), abs=1e-5)
    (link, sensor) = topics["/tf"].messages[0].transforms
    assert (link.header.frame_id, link.child_frame_id) == ("default", "r::base")
    assert (sensor.header.frame_id, sensor.child_frame_id) == ("r::base", "livox")
    assert sensor.transform.translation.z == 0.5


def test_every_second_ray(topics, world, pattern):
    made = plugin(world, robot(pattern, downsample=2))
    made.update(0.1, 0.1)
    assert len(topics["/scan"].messages[0].points) == 2


@pytest.mark.parametrize(
    "kind, frame, step, names",
    [
        (1, "livox", 16, ["x", "y", "z"]),
        (2, "livox", 32, ["x", "y", "z", "reflectivity", "tag", "line"]),
    ],
)
def test_clouds_of_both_kinds(topics, world, pattern, kind, frame, step, names):
    made = plugin(world, robot(pattern, publish_pointcloud_type=kind))
    made.update(0.1, 0.1)
    (cloud,) = topics["/scan"].messages
    assert topics["/scan"].kind is PointCloud2 and cloud.header.frame_id == frame
    assert (cloud.point_step, cloud.width, cloud.height) == (step, 3, 1)
    assert [field.name for field in cloud.fields] == names and cloud.is_dense
    data = np.frombuffer(cloud.data, np.uint8).reshape(3, step)
    assert data[0, :12].view("<f4") == pytest.approx([5.1, 0.0, 0.0], abs=1e-5)
    if kind == 2:
        assert data[:, 16:20].copy().view("<f4").ravel().tolist() == [9.0, 9.0, 9.0]
        assert data[:, 21].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    "values, words",
    [
        ({"csv_file_name": "/nowhere.csv"}, "cannot be read"),
        ({"publish_pointcloud_type": 7}, "must be 0, 1, 2 or 3"),
        ({"publish_pointcloud_type": 3}, "needs livox_ros_driver"),
    ],
)
def test_what_is_wrong_is_told(topics, world, pattern, values, words):
    assert topics == {}
    with pytest.raises(ModelError, match=words):
        plugin(world, robot(**{"path": pattern, **values}))


@pytest.mark.parametrize("name", ["fifo", "/dev/zero", "gz", "http://127.0.0.1:26999/p.csv"])
def test_a_pattern_is_a_file_of_this_machine_that_is_not_too_large(tmp_path, name):
    """A device filled the memory, a pipe held the start for ever, an address was fetched."""
    path = name
    if name == "fifo":
        os.mkfifo(tmp_path / name)
        path = str(tmp_path / name)
    elif name == "gz":
        path = str(tmp_path / "pattern.csv.gz")
        with gzip.open(path, "wb", 9) as file:
            for _ in range(100):
                file.write(b"0.0,0.0,90.0\n" * 100_000)
    reason = "of a livox cannot be read: file .*(no file|has more|No such)"
    with pytest.raises(ModelError, match=reason):
        lidars._read_pattern_of(path)


def test_a_packed_pattern_is_read(tmp_path):
    path = tmp_path / "pattern.csv.gz"
    with gzip.open(path, "wt") as file:
        file.write("time,azimuth,zenith\n" + "0,1.5,90\n" * 30_000 + "0,nan,90\n,,\n\n")
    assert lidars._read_pattern_of(str(path)).shape == (30_000, 3)


@pytest.mark.parametrize("tag", ["samples", "csv_file_name", "ros_topic"])
def test_what_is_missing_is_told(pattern, tag):
    model = parse_urdf(robot(pattern, **{tag: None}), str, "r")
    assert model.sensors == [] and any(f"has no {tag}" in text for text in model.warnings)
