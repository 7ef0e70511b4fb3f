"""./run add: the lists of sources, what is taken from a folder, and a clone that it fills."""

import argparse
import re
import shutil
import signal
import tarfile
import threading
import time
import zipfile

import pytest
import yaml
from run_rig import PATIENCE, run
from users_rig import LIST, MANIFEST, git

from commands import check_remedies
from commands import sources as repos
from commands.bootstrap import workspace
from commands.errors import CommandError, Interrupted, UsageError
from commands.subcommands import add


@pytest.mark.parametrize("name", repos.listed())
def test_each_list_is_complete(name):
    entry = repos.entry_of(name)
    assert entry.about and entry.version and entry.next and entry.repositories
    assert set(entry.needs) <= set(repos.listed())
    for each in entry.repositories:
        assert each.kind == "git" and each.version
        assert re.fullmatch(r"https://github\.com/[\w.-]+/[\w.-]+\.git", each.url)
    for command in entry.next:
        assert "./run " in command


@pytest.mark.parametrize("name", repos.listed())
def test_check_names_what_can_be_added(name):
    packages = repos.entry_of(name).packages
    assert packages and not set(packages) & set(repos.ELSEWHERE)
    for package in packages:
        remedy = check_remedies.for_package(package, lambda _: set(), lambda names: {package: []})
        assert remedy == f"./run add {name}"


@pytest.mark.parametrize("name", ["husky", "jackal"])
def test_robots_bring_what_their_launch_files_start(name):
    brought = {package for entry in repos.entries_of([name]) for package in entry.packages}
    assert {"robot_localization", "teleop_twist_joy", "interactive_marker_twist_server"} <= brought


def test_the_list_is_printed():
    done = run("add", "--list")
    assert done.returncode == 0 and "navigation" in done.stdout
    assert "https://github.com/ros-planning/navigation.git noetic-devel" in done.stdout


@pytest.mark.parametrize(
    "text, folder, version",
    [
        ("https://github.com/somebody/their_robot", "their_robot", ""),
        ("https://github.com/somebody/their_robot.git#noetic-devel", "their_robot", "noetic-devel"),
        ("git@github.com:somebody/robot.git", "robot", ""),
        ("file:///srv/git/robot/", "robot", ""),
    ],
)
def test_urls(text, folder, version):
    (found,) = repos.entry_of(text).repositories
    assert (found.name, found.kind, found.version) == (folder, "git", version)
    assert found.url == text.partition("#")[0]


def test_what_is_neither_in_the_list_nor_a_url():
    with pytest.raises(UsageError, match="name is 'navigatoin'; there are .*navigation"):
        repos.entry_of("navigatoin")
    with pytest.raises(UsageError, match="its last part must name"):
        repos.entry_of("https://example.org/?")


def test_where_a_folder_has_a_repository(sources, tmp_path):
    thing = repos.Repository("thing", "git", "https://example.org/thing.git", "noetic")
    assert add.local(thing, str(sources)).url == str(sources / "thing.git")
    packed = add.local(repos.Repository("packed", "git", "x", "noetic"), str(sources))
    assert (packed.kind, packed.version) == ("tar", "packed-noetic")
    with zipfile.ZipFile(tmp_path / "packed.zip", "w") as archive:
        archive.writestr("package.xml", "")
    zipped = add.local(repos.Repository("packed", "git", "x", "noetic"), str(tmp_path))
    assert (zipped.kind, zipped.version, zipped.url) == ("zip", "", f"file://{tmp_path}/packed.zip")
    with pytest.raises(CommandError, match=r"has neither pack, a clone, nor an archive of it"):
        add.local(repos.Repository("pack", "git", "x", "noetic"), str(sources))


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty src/; returns it."""
    folder = tmp_path / "clone" / "src"
    folder.mkdir(parents=True)
    for module in (add, workspace):
        monkeypatch.setattr(module, "SOURCES", str(folder))
    monkeypatch.setattr(add, "CACHE", str(tmp_path))
    return folder


def tar(path, *members):
    """Writes a tar of (name, type, link's target)."""
    with tarfile.open(path, "w") as archive:
        for name, kind, target in members:
            member = tarfile.TarInfo(name)
            member.type, member.linkname = kind, target
            archive.addfile(member)


@pytest.mark.parametrize(
    "member, outside",
    [
        (("thing/a", tarfile.REGTYPE, ""), None),
        (("thing/a/b", tarfile.SYMTYPE, "../c"), None),
        (("thing/../../b", tarfile.REGTYPE, ""), "thing/../../b"),
        (("/b", tarfile.REGTYPE, ""), "/b"),
        (("thing/a", tarfile.SYMTYPE, "../../b"), "thing/../../b"),
        (("thing/a", tarfile.SYMTYPE, "/b"), "/b"),
        (("thing/a", tarfile.LNKTYPE, "../b"), "../b"),
        (("thing/a", tarfile.CHRTYPE, ""), "/dev/null"),
        (("thing/a", tarfile.FIFOTYPE, ""), "/dev/null"),
    ],
)
def test_archives_fill_no_other_folder(tmp_path, member, outside):
    """vcstool unpacks where a member's name leads."""
    path = str(tmp_path / "thing.tar")
    tar(path, ("thing/package.xml", tarfile.REGTYPE, ""), member)
    if outside is None:
        assert add.top_folder(path, "tar") == "thing"
    else:
        with pytest.raises(CommandError, match=f"'{outside}' of it is outside of it"):
            add.top_folder(path, "tar")


@pytest.mark.parametrize("kind", ["tar", "zip"])
def test_damaged_archives_are_named(tmp_path, kind):
    path = tmp_path / f"thing.{kind}"
    for data in (b"", b"PK\x05\x06" + bytes(10), b"\x1f\x8b" + bytes(100), b"x" * 5000):
        path.write_bytes(data)
        with pytest.raises(CommandError, match=f"{path} cannot be unpacked"):
            add.top_folder(str(path), kind)


def test_branches_that_yaml_reads_as_numbers(here, tmp_path, monkeypatch):
    """1.10 was brought as 1.1."""
    (tmp_path / "vcs").write_text('#!/bin/bash\ncp "$5" "$6/../../../said"\nexit 0\n')
    (tmp_path / "vcs").chmod(0o755)
    monkeypatch.setattr(add.deps, "VCS", str(tmp_path / "vcs"))
    for version in ("1.10", "0x10", "on", "a: b", "2024-01-01"):
        add._import(repos.Repository("thing", "git", "file:///x#y", version), str(here / add.PART))
        entry = yaml.safe_load((tmp_path / "said").read_text())["repositories"]["thing"]
        assert (entry["version"], entry["url"]) == (version, "file:///x#y")


def package(folder, name):
    """Writes a package into a folder."""
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(MANIFEST.format(name))
    return folder


def test_submodules_come_with_their_repository(sources, here, tmp_path, capsys):
    robot = package(tmp_path / "from" / "robot", "robot")
    git(robot, "init", "-q")
    url = f"file://{sources}/thing.git"
    git(robot, "-c", "protocol.file.allow=always", "submodule", "add", "-q", url, "things")
    with (robot / ".gitmodules").open("a") as modules:
        modules.write('[submodule "lost"]\npath = lost\nurl = git@github.com:nobody/lost.git\n')
    git(robot, "add", ".")
    git(robot, "commit", "-q", "-m", "first")
    shutil.copytree(sources / "thing.git", tmp_path / "from" / "thing.git")
    add.bring(repos.Repository("robot", "git", "https://example.org/robot.git"), str(robot.parent))
    assert (here / "robot" / "things" / "README").exists()
    said = capsys.readouterr().out
    assert f"{here}/robot/things: file://{sources}/thing.git, a submodule\n" in said
    assert f"left out: submodule {here}/robot/lost (git@github.com:nobody/lost.git): " in said


def test_of_two_packages_of_a_name_one_is_used(here, capsys):
    old = package(here / "first" / "my_robot", "my_robot")
    new = package(here / "second" / "my_robot", "my_robot")
    copy = package(here / "second" / "amcl", "amcl")
    real = package(here / "navigation" / "amcl", "amcl")
    assert set(workspace.copies()) == {"my_robot", "amcl"}
    add.leave_copies(["second"])
    assert workspace.users_packages() == {"my_robot": str(new), "amcl": str(real)}
    assert (old / "CATKIN_IGNORE").exists() and (copy / "CATKIN_IGNORE").exists()
    said = capsys.readouterr().out
    assert f"my_robot: {new} is used; {old} is disabled by its file CATKIN_IGNORE\n" in said
    add.leave_copies(["second"])
    assert capsys.readouterr().out == ""


def test_what_a_name_needs_comes_before_it(monkeypatch, tmp_path):
    monkeypatch.setattr(repos, "FOLDER", str(tmp_path))
    fields = "# needs: thing\n# without: a b    # they want a real camera\n"
    (tmp_path / "more.repos").write_text(
        LIST.replace("thing", "more").replace("# version", fields + "# version")
    )
    (tmp_path / "thing.repos").write_text(LIST)
    more, thing = repos.entry_of("more"), repos.entry_of("thing")
    assert (more.needs, more.without, thing.needs) == (("thing",), ("a", "b"), ())
    assert repos.entries_of(["more"]) == [thing, more] == repos.entries_of(["thing", "more"])


def test_packages_of_a_repository_are_left_out(here, capsys):
    for name in ("driver", "description"):
        package(here / add.PART / "camera" / name, name)
    add.leave_out(["driver", "driver_2"], str(here / add.PART / "camera"))
    (here / add.PART / "camera").rename(here / "camera")
    assert set(workspace.users_packages()) == {"description"}
    said = f"driver: {here}/camera/driver is disabled by its file CATKIN_IGNORE\n"
    assert capsys.readouterr().out == said


# What vcstool does, in place of it: half a clone, then a word of bash.
HALF = '#!/bin/bash\nmkdir -p "$6/thing"\ntouch "$6/thing/half"\n{}\n'


@pytest.fixture
def signals():
    """Puts the handlers back: a ./run that is interrupted ignores all further signals."""
    before = {number: signal.getsignal(number) for number in (2, 15, 1)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("signals")
@pytest.mark.parametrize(
    "word, error",
    [
        ("kill -INT $PPID; sleep 1000", Interrupted),
        ("kill -TERM $PPID; sleep 1000", Interrupted),
        ("echo 'fatal: no space left'; exit 1", CommandError),
    ],
)
def test_half_a_clone_never_counts_as_there(here, sources, tmp_path, monkeypatch, word, error):
    """Ctrl-C, then the same again: what was half brought stayed, with exit status 0."""
    thing = repos.Repository("thing", "git", "https://example.org/thing.git", "noetic")
    (tmp_path / "vcs").write_text(HALF.format(word))
    (tmp_path / "vcs").chmod(0o755)
    with monkeypatch.context() as patch:
        patch.setattr(add.deps, "VCS", str(tmp_path / "vcs"))
        with pytest.raises(error):
            add.bring(thing, str(sources))
    assert list(here.iterdir()) == []
    (here / add.PART / "thing").mkdir(parents=True)  # by SIGKILL
    (here / add.PART / "thing" / "half").touch()
    add.bring(thing, str(sources))
    assert sorted(path.name for path in here.iterdir()) == ["thing"]
    assert (here / "thing" / "package.xml").exists() and not (here / "thing" / "half").exists()


def test_two_at_once_wait_for_each_other(tmp_path, monkeypatch, capfd):
    """Both wrote the same list for vcstool: one repository was not brought, with exit status 0."""
    monkeypatch.setattr(add, "CACHE", str(tmp_path))
    monkeypatch.setattr(add.step, "SILENT", 0.0)
    asked = []
    monkeypatch.setattr(add, "add", lambda names, _: asked.append(names))
    options = argparse.Namespace(list=False, names=["thing"], folder=None)
    second = threading.Thread(target=add.run, args=(options, []))
    with add.step.SetupLock(str(tmp_path / add.LOCK)):
        second.start()
        told, end = "", time.monotonic() + PATIENCE
        while not told and time.monotonic() < end:
            told = capfd.readouterr().err
            time.sleep(0.05)
        assert told.startswith("another ./run is bringing packages, waiting for it") and not asked
    second.join(PATIENCE)
    assert asked == [["thing"]]
