"""Track and route files that are broken on purpose: a TrackError that names the file, soon."""

import io
import os
import pathlib
import pickle
import struct

import numpy as np
import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st
from track_model.spec import TrackError

from track_model import source

FEW = settings(derandomize=True, deadline=None, max_examples=60, database=None)
LAUGHS = "".join(f"{chr(98 + n)}: &{chr(98 + n)} [{','.join([f'*{chr(97 + n)}'] * 9)}]\n" for n in range(12))  # fmt: skip  # noqa: E501
TRACK = pathlib.Path(source.tracks_directory(), "hard.yaml").read_bytes()


def refused(name, content):
    """The message with which a file is refused."""
    with pytest.raises(TrackError, match=name) as caught:
        source.load(name, content if isinstance(content, bytes) else content.encode())
    return str(caught.value)


def npy(shape, dtype="<f8", data=b""):
    """A .npy file whose header does not match its data."""
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + data


class Command:
    """Makes a folder when it is unpickled."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return os.mkdir, (self.path,)


@pytest.mark.parametrize(
    "content",
    [
        "[" * 50_000,
        "{a: " * 20_000,
        "width: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\na: *a\n" + LAUGHS.replace("*a", "1"),
        "points: &a [*a, *a, *a]\n",
        "a: &a [1]\n" + LAUGHS + "points: *m\n",
        "points: [[0, 0], [1, 0], [1, 1]]\nseed: " + "9" * 5000,
        "points: [[0, 0], [1, 0], [1, 1]]\nwidth: 1" + "0" * 400,
        "points: [[0, 0], [1, 0], [1, 1]]\nwidth: 1.0e+400",
        "width: 9999-99-99",
        "points: !!python/object/apply:os.system ['true']",
        "? [a]\n: b",
        "\0" * 100,
        "# " + "x" * 300_000,
    ],
    ids=lambda text: repr(text[:16]),
)
def test_a_broken_yaml_track_is_refused_in_one_short_sentence(content):
    assert len(refused("t.yaml", content)) < 2000


@pytest.mark.parametrize(
    "content",
    [
        npy((10**9, 6)),
        npy((10**15, 6)),
        npy((2**62, 6)),
        npy((-5, 6)),
        npy((10**40, 6)),
        npy((5, 6), "|O"),
        npy((5, 6), "V999999999"),
        npy("(" * 5000),
        npy((0, 6)),
        b"\x93NUMPY\x02\x00" + struct.pack("<I", 2**32 - 1) + b"(",
        b"",
    ],
    ids=lambda content: repr(content[60:80]),
)
def test_a_broken_array_is_refused(content):
    refused("t.npy", content)


def test_a_pickle_is_refused_and_not_run(tmp_path):
    folder, stream = tmp_path / "made", io.BytesIO()
    np.save(stream, np.array([Command(folder)], object), allow_pickle=True)
    for content in (stream.getvalue(), pickle.dumps(Command(folder))):
        assert "not an array file" in refused("t.npy", content)
    assert not folder.exists()


@pytest.mark.parametrize(
    "content",
    ["1e999,2,3,4\n1,2,3,4\n", "1," * 100_000, "1,2,3,4\n" * 1000, "\0", "\ufeff", "nan,1,1,1"],
    ids=lambda text: repr(text[:12]),
)
def test_a_broken_table_is_refused(content):
    refused("t.csv", content)


def test_what_is_no_file_or_too_long(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    long = tmp_path / "long.csv"
    with long.open("wb") as stream:
        stream.truncate(source.MAX_SIZE + 1)
    for path in (tmp_path / "pipe.csv", tmp_path, "/dev/zero", long):
        with pytest.raises(TrackError, match=str(path)):
            source.read(str(path))


@seed(1)
@FEW
@given(st.binary(max_size=200) | st.text("0123456789.,;#-e+ \n", max_size=200).map(str.encode))
def test_any_bytes_are_a_route_or_refused(content):
    for name in ("t.npy", "t.csv"):
        try:
            source.load(name, content)
        except TrackError as error:
            assert name in str(error)
