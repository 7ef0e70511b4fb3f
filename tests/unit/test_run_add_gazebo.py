"""Packages for ./run add gazebo are unpacked whole or not at all, where they are needed."""

import subprocess
from types import SimpleNamespace

import pytest

from commands import gazebo_libraries
from commands.bootstrap import workspace
from commands.errors import CommandError
from commands.paths import os_release

DEBIAN = 'ID=debian\nVERSION_ID="12"\n'


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Two packages' files in a folder, and a cache without any."""
    files = tmp_path / "files"
    files.mkdir()
    for name in ("libone", "libtwo"):
        root = tmp_path / name
        (root / "DEBIAN").mkdir(parents=True)
        (root / "DEBIAN" / "control").write_text(
            f"Package: {name}\nVersion: 1\nArchitecture: all\nMaintainer: nobody <a@b.c>\n"
            "Description: of a test\n"
        )
        (root / "usr" / "lib").mkdir(parents=True)
        (root / "usr" / "lib" / f"{name}.so").write_text(name)
        target = files / f"{name}_1_all.deb"
        subprocess.run(["dpkg-deb", "--build", root, target], check=True, capture_output=True)
    listed = tmp_path / "list.txt"
    listed.write_text("# packages\nlibone\nlibtwo\n")
    prefix = tmp_path / "cache" / "gazebo"
    prefix.parent.mkdir()
    places = {"OLD_LIST": listed, "PREFIX": prefix, "STAMP": prefix / "packages.txt"}
    for name, value in places.items():
        monkeypatch.setattr(gazebo_libraries, name, str(value))
    monkeypatch.setattr(
        gazebo_libraries, "os_release", lambda text: os_release(DEBIAN if text is None else text)
    )
    monkeypatch.setattr(gazebo_libraries.packages, "prepare", lambda *_: None)
    return tmp_path


def test_packages_are_unpacked_once(place, capsys):
    gazebo_libraries.add(str(place / "files"))
    prefix = place / "cache" / "gazebo"
    assert {path.name for path in (prefix / "usr" / "lib").iterdir()} == {"libone.so", "libtwo.so"}
    assert [path.name for path in prefix.parent.iterdir()] == ["gazebo"]
    assert "MB" in capsys.readouterr().out
    gazebo_libraries.add(str(place / "no such folder"))
    assert "stays as it is" in capsys.readouterr().out


def test_what_is_not_whole_is_not_there(place):
    (place / "files" / "libtwo_1_all.deb").unlink()
    with pytest.raises(CommandError, match=r"has no libtwo_\*.deb"):
        gazebo_libraries.add(str(place / "files"))
    (place / "files" / "libtwo_1_all.deb").write_text("no package")
    with pytest.raises(CommandError, match=r"libtwo_1_all.deb cannot be unpacked: dpkg-deb: error"):
        gazebo_libraries.add(str(place / "files"))
    assert list((place / "cache").iterdir()) == []


@pytest.mark.parametrize(
    ("release", "advice"),
    [
        ('ID=debian\nVERSION_ID="13"\n', "development files"),
        ('ID=ubuntu\nVERSION_ID="20.04"\n', "libgazebo11-dev"),
        ("", "development files"),
    ],
)
def test_other_systems_use_what_they_have(place, release, advice):
    with pytest.raises(CommandError, match=r"on Debian 12 alone, this is") as caught:
        gazebo_libraries.check_system(release)
    assert advice in str(caught.value) + str(vars(caught.value)) + str(caught.value.args)


def test_the_list_has_what_the_host_is_linked_with():
    names = gazebo_libraries.names()
    assert {"libgazebo11", "libgazebo-dev", "libsdformat9-9", "libignition-math6-6"} <= set(names)
    assert names == sorted(set(names))


def test_the_workspace_is_configured_with_what_came(place, monkeypatch):
    none = SimpleNamespace(glob=lambda *_: [])
    monkeypatch.setattr(workspace, "glob", none)  # no Gazebo is installed
    monkeypatch.setattr(workspace, "GAZEBO_STAMP", gazebo_libraries.STAMP)
    before = workspace._gazebo()
    gazebo_libraries.add(str(place / "files"))
    assert workspace._gazebo() != before  # catkin_make calls cmake where its arguments differ
