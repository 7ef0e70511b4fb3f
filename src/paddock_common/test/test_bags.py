"""Rosbags of others: damaged, larger than they look, with definitions that would execute."""

import bz2
import pathlib

import pytest
import rosbag
import rospy
from nav_msgs.msg import Odometry

from paddock_common import bags

WANTED = {"/odom": "nav_msgs/Odometry"}
HARM = 'int8 open("{}","w");A=1\n'  # of genpy's a line of Python that is executed


def written(path, compression="none", kind=Odometry):
    with rosbag.Bag(str(path), "w", compression=compression) as target:
        for second in (1, 2, 3):
            target.write("/odom", kind(), rospy.Time(second))
    return path


def read(path):
    with bags.Bag(str(path)) as bag:
        return [stamp.secs for _, _, stamp in bag.messages(WANTED)], bag.others


@pytest.mark.parametrize("compression", ["none", "bz2"])
def test_messages_are_read(tmp_path, compression):
    assert read(written(tmp_path / "a.bag", compression)) == ([1, 2, 3], set())


@pytest.mark.parametrize("same_sum", [True, False])
def test_definitions_of_a_bag_are_not_executed(tmp_path, monkeypatch, same_sum):
    """rosbag executes the names of their constants."""
    harm = tmp_path / "harm"

    class Other(Odometry):
        _full_text = HARM.format(harm) + Odometry._full_text
        _md5sum = Odometry._md5sum if same_sum else "0" * 32

    path = written(tmp_path / "a.bag", kind=Other)
    monkeypatch.setattr(rosbag.bag, "_message_types", {})
    stamps, others = read(path)
    assert (stamps, others) == (([1, 2, 3], set()) if same_sum else ([], {"/odom"}))
    assert not harm.exists()


def cut(data):
    return data[: len(data) // 2]


def zeros(data):
    return data[:100] + bytes(len(data) - 100)


def long_header(data):
    return data[:20] + b"\xff\xff\xff\x7f" + data[24:]


def wrong_index(data):
    at = data.rindex(b"op=\x04")
    return data[:at] + data[at:].replace(b"\x01\0\0\0", b"\xff\xff\xff\x7f")


def other_offsets(data):
    at = data.rindex(b"chunk_pos=") + 10
    return data[:at] + b"\x11" + data[at + 1 :]


@pytest.mark.parametrize("change", [cut, zeros, long_header, wrong_index, other_offsets,
                                    lambda data: b"", lambda data: b"#ROSBAG V2.0\n"])  # fmt: skip
@pytest.mark.parametrize("compression", ["none", "bz2"])
def test_damaged_bags_are_one_sentence(tmp_path, change, compression):
    path = written(tmp_path / "a.bag", compression)
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(bags.BagError, match="a.bag (is no bag|was not recorded to its end)"):
        read(path)


def test_changed_bytes_never_raise_anything_else(tmp_path):
    path = written(tmp_path / "a.bag")
    data = path.read_bytes()
    for at in range(13, len(data), 23):
        path.write_bytes(data[:at] + bytes([data[at] ^ 0xFF]) + data[at + 1 :])
        try:
            read(path)
        except bags.BagError as error:
            assert "\n" not in str(error)


def test_what_a_chunk_unpacks_to_is_limited(tmp_path, monkeypatch):
    """45 bytes of bz2 are 900 kB: a bag of 5 MB was 100 GB of memory."""
    path = written(tmp_path / "a.bag", "bz2")
    monkeypatch.setattr(bags, "CHUNK", 1000)
    with pytest.raises(bags.BagError, match="a chunk has more than 0 MB, unpacked"):
        read(path)
    assert bags._limited(bz2.BZ2Decompressor)(bz2.compress(b"a" * 1000)) == b"a" * 1000


def test_what_is_no_file_is_named(tmp_path):
    for path in (tmp_path, tmp_path / "none.bag", pathlib.Path("/dev/null")):
        with pytest.raises(bags.BagError, match=f"{path} is no bag that can be read"):
            read(path)
