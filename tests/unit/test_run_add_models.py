"""./run add models: what files name of Gazebo's database, from a clone, and what these name."""

import os
import shutil

import pytest
from run_rig import make_package
from users_rig import commit, git

from commands import gazebo_models, sources
from commands.errors import CommandError, UsageError


@pytest.fixture
def clone(tmp_path, monkeypatch):
    """A clone of the database with three models; one names another."""
    folder = tmp_path / "gazebo_models"
    for name, text in (("cafe_table", ""), ("bookshelf", ""),
                       ("cafe", "<uri>model://cafe_table/meshes/a.dae</uri>")):  # fmt: skip
        (folder / name).mkdir(parents=True)
        (folder / name / "model.sdf").write_text(f"<sdf>{text}</sdf>" + " " * 100_000)
    git(folder, "init", "--quiet")
    commit(folder)
    monkeypatch.setattr(gazebo_models, "MODELS", str(tmp_path / "cache" / "gazebo_models"))
    monkeypatch.setattr(gazebo_models, "CACHE", str(tmp_path / "cache"))
    (tmp_path / "cache").mkdir()
    return str(folder)


def there():
    return {name for name in os.listdir(gazebo_models.MODELS) if name[0] != "."}


def test_what_a_world_names_is_brought_and_nothing_else(clone, tmp_path, capsys):
    world = tmp_path / "a.world"
    world.write_text(
        "<uri>model://sun</uri><uri>model://bookshelf</uri><!-- <uri>model://cafe_table</uri> -->"
        "<uri>model://shed_of_mine</uri>"
    )
    gazebo_models.add([str(world)], clone)
    assert there() == {"bookshelf"}
    assert "bookshelf: 0.1 MB" in capsys.readouterr().out


def test_models_bring_those_that_they_name_beside_what_is_there(clone):
    gazebo_models.add(["bookshelf"], clone)
    gazebo_models.add(["cafe"], clone)
    assert there() == {"bookshelf", "cafe", "cafe_table"}


def test_what_a_killed_run_has_left_is_completed(clone, tmp_path):
    """Half a model counted as there, and git's lock stayed for ever."""
    gazebo_models.add(["bookshelf"], clone)
    model = tmp_path / "cache" / "gazebo_models" / "bookshelf" / "model.sdf"
    for harm in ("model.sdf", "half", ".git"):
        if harm == "model.sdf":
            model.unlink()
        elif harm == "half":
            model.write_text("<sdf>")
        else:
            shutil.rmtree(gazebo_models.MODELS)
            os.makedirs(f"{gazebo_models.MODELS}.part/.git")
        if harm != ".git":
            (tmp_path / "cache" / "gazebo_models" / ".git" / "index.lock").touch()
        gazebo_models.add(["bookshelf"], clone)
        assert model.stat().st_size > 100_000, harm


def test_a_package_stands_for_its_files(clone, tmp_path, monkeypatch):
    worlds = make_package(tmp_path / "src" / "yard", "yard") / "worlds"
    worlds.mkdir()
    (worlds / "a.world").write_text('<include><uri>"model://cafe_table"</uri></include>')
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    gazebo_models.add(["yard"], clone)
    assert there() == {"cafe_table"}


def test_what_cannot_be_had_is_named(clone):
    with pytest.raises(UsageError, match="'cafe_tabel' is no model of Gazebo's database"):
        gazebo_models.add(["cafe_tabel"], clone)
    with pytest.raises(CommandError, match="jersey_barrier: not in https://github.com/osrf"):
        gazebo_models.add(["jersey_barrier"], clone)


def test_the_list_of_the_database():
    names = sources.database()
    assert {"jersey_barrier", "construction_barrel", "cafe_table", "pine_tree"} <= names
    assert len(names) > 250 and not any("/" in name for name in names)
