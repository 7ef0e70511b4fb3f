"""Models that include what is no file, too much, or each other: left out by name, soon."""

import os
import time

import pytest
from bullet_sim.errors import ModelError
from bullet_sim.files import read_file
from bullet_sim.formats.sdf.includes import MAX_INCLUDES
from bullet_sim.formats.sdf.world import parse_model, parse_world

LONGEST = 5.0  # [s] of CPU time
INCLUDE = "<include><uri>{}</uri></include>"


def world_of(uri):
    """A world file that includes one model."""
    return f'<sdf version="1.6"><world name="w">{INCLUDE.format(uri)}</world></sdf>'


@pytest.fixture(name="places")
def _places(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with open(tmp_path / "long.sdf", "wb") as file:
        file.truncate(10**9)
    return [str(tmp_path / "pipe"), str(tmp_path / "long.sdf"), str(tmp_path), "/dev/zero"]


def test_a_world_leaves_out_what_is_no_file(places):
    for path in places:
        found = parse_world(world_of(path), str)
        assert len(found.warnings) == 1 and f"'{path}'" in found.warnings[0]


def test_a_file_is_read_up_to_its_bound(tmp_path, places, monkeypatch):
    path = tmp_path / "a"
    path.write_bytes(b"1234")
    monkeypatch.setenv("PADDOCK_MAX_TEXT_BYTES", "4")
    assert read_file(str(path), "list", "text_bytes") == b"1234"
    monkeypatch.setenv("PADDOCK_MAX_TEXT_BYTES", "3")
    with pytest.raises(ModelError, match=f"list '{path}' has 4 bytes, must have at most 3"):
        read_file(str(path), "list", "text_bytes")
    monkeypatch.delenv("PADDOCK_MAX_TEXT_BYTES")
    with pytest.raises(ModelError, match="/proc/self/status' has more than the 0 bytes"):
        read_file("/proc/self/status", "list", "text_bytes")
    for place in places:
        with pytest.raises(ModelError, match=place):
            read_file(place, "list", "text_bytes")


def test_models_that_include_each_other_many_times_are_bounded(tmp_path):
    for number in range(8):
        inner = INCLUDE.format(tmp_path / f"{number + 1}.sdf") * 10
        text = f'<sdf version="1.6"><model name="m">{inner}<link name="l"/></model></sdf>'
        (tmp_path / f"{number}.sdf").write_text(text)
    (tmp_path / "8.sdf").write_text('<sdf><model name="m"><link name="l"/></model></sdf>')
    begin = time.process_time()
    model, _ = parse_model((tmp_path / "0.sdf").read_text(), str)
    assert time.process_time() - begin < LONGEST
    assert len(model.links) == MAX_INCLUDES + 1
    assert any("1000 models are included already" in text for text in model.warnings)
