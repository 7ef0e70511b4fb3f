"""./run add: the lists of sources, what is taken from a folder, and a clone that it fills."""

import re
import shutil
import signal
import tarfile
import threading
import time
import zipfile

import pytest
import yaml
from run_rig import PATIENCE, make_package, program, run
from users_rig import commit, git

from commands import cli, repositories
from commands import sources as repos
from commands.bootstrap import workspace
from commands.errors import CommandError, Interrupted, UsageError
from commands.subcommands import add


def test_the_index_is_complete():
    repositories, packages, releases = repos.index()
    assert len(repositories) > 800 and len(packages) > 2000 and len(releases) > 600
    assert releases.keys() <= repositories.keys()
    assert all(repos.PACKAGE in version for _, _, version, _ in releases.values())
    for kind, url, version, names in repositories.values():
        assert kind == "git" and version and names
        assert re.fullmatch(r"(https|git)://\S+", url)


@pytest.mark.parametrize("name, places", [
    ("navigation", [("navigation", "noetic-devel", 16)]),
    ("map_server", [("navigation", "noetic-devel", 1)]),
    ("explore_lite", [("m-explore", "noetic-devel", 1)]),
    ("libg2o", [("libg2o", "release/noetic/libg2o/2020.5.3-1", 0)]),  # has a release alone
    ("turtlebot3", [("turtlebot3", "noetic", 7)]),  # the index names a branch that is gone
    ("scout", [("ugv_gazebo_sim", "master", 3)]),  # is in no index
    ("https://github.com/somebody/their_robot", [("their_robot", "", 0)]),
    ("https://github.com/a/their_robot.git#noetic-devel", [("their_robot", "noetic-devel", 0)]),
    ("git@github.com:somebody/robot.git", [("robot", "", 0)]),
    ("file:///srv/git/robot/", [("robot", "", 0)]),
])  # fmt: skip
def test_where_a_name_has_its_sources(name, places):
    found = repos.repositories_of(name)
    assert [(each.name, each.version, len(each.only)) for each in found] == places
    if ":" in name:
        assert (found[0].kind, found[0].url) == ("git", name.partition("#")[0])


def test_the_list_is_printed():
    done = run("add", "--list")
    assert done.returncode == 0 and "# Not in the index:\ncartographer git " in done.stdout
    assert re.search(r"\d+ repositories, \d+ packages\n$", done.stdout)


def test_where_a_folder_has_a_repository(sources, tmp_path):
    thing = repos.Repository("thing", "git", "https://example.org/thing.git", "noetic")
    assert repositories.local(thing, str(sources)).url == str(sources / "thing.git")
    packed = repositories.local(repos.Repository("packed", "git", "x", "noetic"), str(sources))
    assert (packed.kind, packed.version) == ("tar", "packed-noetic")
    with zipfile.ZipFile(tmp_path / "packed.zip", "w") as archive:
        archive.writestr("package.xml", "")
    zipped = repositories.local(repos.Repository("packed", "git", "x", "noetic"), str(tmp_path))
    assert (zipped.kind, zipped.version, zipped.url) == ("zip", "", f"file://{tmp_path}/packed.zip")
    with pytest.raises(CommandError, match=r"has neither pack, a clone, nor an archive of it"):
        repositories.local(repos.Repository("pack", "git", "x", "noetic"), str(sources))


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty src/; returns it."""
    folder = tmp_path / "clone" / "src"
    folder.mkdir(parents=True)
    for module in (repositories, workspace):
        monkeypatch.setattr(module, "SOURCES", str(folder))
    for module in (add, repositories):
        monkeypatch.setattr(module, "CACHE", str(tmp_path))
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
        assert repositories.top_folder(path, "tar") == "thing"
    else:
        with pytest.raises(CommandError, match=f"'{outside}' of it is outside of it"):
            repositories.top_folder(path, "tar")


@pytest.mark.parametrize("kind", ["tar", "zip"])
def test_damaged_archives_are_named(tmp_path, kind):
    path = tmp_path / f"thing.{kind}"
    for data in (b"", b"PK\x05\x06" + bytes(10), b"\x1f\x8b" + bytes(100), b"x" * 5000):
        path.write_bytes(data)
        with pytest.raises(CommandError, match=f"{path} cannot be unpacked"):
            repositories.top_folder(str(path), kind)


def test_branches_that_yaml_reads_as_numbers(here, tmp_path, monkeypatch):
    """1.10 was brought as 1.1."""
    program(tmp_path / "vcs", '#!/bin/bash\ncp "$5" "$6/../../../said"\nexit 0\n')
    monkeypatch.setattr(repositories.deps, "VCS", str(tmp_path / "vcs"))
    for version in ("1.10", "0x10", "on", "a: b", "2024-01-01"):
        repositories._import(
            repos.Repository("thing", "git", "file:///x#y", version), str(here / repositories.PART)
        )
        entry = yaml.safe_load((tmp_path / "said").read_text())["repositories"]["thing"]
        assert (entry["version"], entry["url"]) == (version, "file:///x#y")


def test_submodules_come_with_their_repository(sources, here, tmp_path, capsys):
    robot = make_package(tmp_path / "from" / "robot", "robot")
    git(robot, "init", "-q")
    url = f"file://{sources}/thing.git"
    git(robot, "-c", "protocol.file.allow=always", "submodule", "add", "-q", url, "things")
    with (robot / ".gitmodules").open("a") as modules:
        modules.write('[submodule "lost"]\npath = lost\nurl = git@github.com:nobody/lost.git\n')
    commit(robot)
    shutil.copytree(sources / "thing.git", tmp_path / "from" / "thing.git")
    repositories.bring(
        repos.Repository("robot", "git", "https://example.org/robot.git"), str(robot.parent)
    )
    assert (here / "robot" / "things" / "README").exists()
    said = capsys.readouterr().out
    assert f"{here}/robot/things: file://{sources}/thing.git, a submodule\n" in said
    assert f"left out: submodule {here}/robot/lost (git@github.com:nobody/lost.git): " in said


def test_of_two_packages_of_a_name_one_is_used(here, capsys):
    old = make_package(here / "first" / "my_robot", "my_robot")
    new = make_package(here / "second" / "my_robot", "my_robot")
    copy = make_package(here / "second" / "amcl", "amcl")
    real = make_package(here / "navigation" / "amcl", "amcl")
    assert set(workspace.copies()) == {"my_robot", "amcl"}
    add.leave_copies(["second"])
    assert workspace.users_packages() == {"my_robot": str(new), "amcl": str(real)}
    assert (old / "CATKIN_IGNORE").exists() and (copy / "CATKIN_IGNORE").exists()
    said = capsys.readouterr().out
    assert f"my_robot: {new} is used; {old} is disabled by its file CATKIN_IGNORE\n" in said
    add.leave_copies(["second"])
    assert capsys.readouterr().out == ""


def test_of_a_repository_what_is_asked_for_is_enabled(here, capsys):
    camera = here / "camera"
    make_package(camera / "driver", "driver", "vendor")
    make_package(camera / "description", "description", "meshes")
    make_package(camera / "meshes", "meshes")
    make_package(camera / "viewer", "viewer", "driver", tag="test_depend")
    repositories.enable(str(camera), ("description",), is_new=True)
    assert set(workspace.users_packages()) == {"description", "meshes"}
    assert "disabled by CATKIN_IGNORE: driver, viewer\n" in capsys.readouterr().out
    repositories.enable(str(camera), ("viewer",), is_new=False)
    assert set(workspace.users_packages()) == {"description", "meshes", "viewer"}
    (camera / "driver" / "CATKIN_IGNORE").write_text("")  # the user's
    repositories.enable(str(camera), (), is_new=False)
    assert "driver" not in workspace.users_packages()


def test_packages_that_the_index_guesses_wrong_disable_none(here):
    make_package(here / "camera" / "driver", "driver")
    repositories.enable(str(here / "camera"), ("camera",), is_new=True)
    assert set(workspace.users_packages()) == {"driver"}


@pytest.fixture
def hosted(tmp_path, monkeypatch):
    """Repositories of packages in a folder, which an index has; from a name to what it wants."""
    folder, lines = tmp_path / "hosted", []

    def host(name, *wanted):
        make_package(folder / name, name, *wanted)
        git(folder / name, "init", "-q", "-b", "main")
        commit(folder / name)
        lines.append(f"{name} git https://example.org/{name}.git main {name}\n")
        (tmp_path / "index.txt").write_text("".join(lines))
        return folder

    monkeypatch.setattr(repos, "INDEX", str(tmp_path / "index.txt"))
    monkeypatch.setattr(repos, "MORE", str(tmp_path / "none.txt"))
    repos.index.cache_clear()
    yield host
    repos.index.cache_clear()


def test_what_packages_depend_on_comes_round_after_round(here, hosted, monkeypatch, capsys):
    hosted("robot", "drive", "rospy", "nobodys")
    hosted("drive", "wheels")
    folder = hosted("wheels", "robot")
    hosted("sensor")
    with open(repos.INDEX, "a") as index:
        index.write("lost git https://example.org/lost.git main lost\n")
    make_package(folder / "robot" / "more", "more")  # not of the repository's commit
    monkeypatch.setattr(add.deps, "has_lists", lambda: True)
    find = add.deps.find

    def resolve(names, _):
        return {name: ["python3-rospy"] * (name == "rospy") for name in names}

    def found(folders, tests):
        ours = {"catkin", *workspace.users_packages()}
        return find(folders, set, lambda _: {"python3-rospy"}, ours, resolve, tests)

    monkeypatch.setattr(add.deps, "find", found)
    nowhere = add.bring_all(repos.repositories_of("robot"), {"lost": ["me"]}, str(folder))
    assert set(workspace.users_packages()) == {"robot", "drive", "wheels"}
    assert nowhere == {"nobodys": ["robot"], "lost": ["me"]}
    assert f"left out: {folder} has neither lost, a clone" in capsys.readouterr().out


def test_a_branch_that_is_gone_comes_from_the_release(here, hosted, capsys):
    """The rqt family's noetic-devel, which the index names, is gone from its repositories."""
    folder = hosted("robot")
    url = "https://example.org/robot-release.git"
    with open(repos.INDEX, "a") as index:
        index.write("robot git https://example.org/robot.git gone robot drive\n")
        index.write(f"robot git {url} release/{{package}}/1.0\n")
    repos.index.cache_clear()
    released = folder / "robot-release"
    released.mkdir()
    git(released, "init", "-q", "-b", "main")
    for name in ("robot", "drive"):
        git(released, "checkout", "-q", "-b", f"release/{name}/1.0")
        commit(make_package(released, name))
    for name, came in [("robot", {"robot", "drive"}), ("drive", {"drive"})]:
        (repository,) = repos.repositories_of(name)
        folders = repositories.bring(repository, str(folder))
        assert folders == [f"{each}-release" for each in repository.only]
        assert set(workspace.users_packages()) == came
        for each in folders:
            shutil.rmtree(here / each)
    assert capsys.readouterr().out.count("its release is looked for\n") == 1
    git(folder / "robot", "checkout", "-q", "-b", "gone")  # it is there, but is no ROS package
    (folder / "robot" / "package.xml").rename(folder / "robot" / "setup.py")
    commit(folder / "robot")
    repositories._lost.clear()
    assert repositories.bring(repos.repositories_of("drive")[0], str(folder)) == ["drive-release"]
    assert "robot has no package.xml of drive: its release" in capsys.readouterr().out
    git(folder / "robot", "branch", "-q", "-m", "other")
    shutil.rmtree(here / "drive-release")
    repositories._lost.clear()
    shutil.rmtree(released)
    with pytest.raises(CommandError, match="/hosted/robot gone cannot be brought"):
        repositories.bring(repos.repositories_of("drive")[0], str(folder))


def test_sizes_are_told_before_anything_is_compiled(here):
    make_package(here / "robot" / "a", "a")
    (here / "robot" / "a" / "main.cpp").write_text("int main() {}\n" * 10)
    (here / "robot" / "a" / "main.hpp").write_text("\n" * 5)
    first, last = add.sizes({"a": str(here / "robot" / "a")}, ["a"])
    assert first == "robot: a; 1 C++ files, 15 lines with headers"
    assert re.fullmatch(r"to compile: 1 files, about 1 min on \d+ cores", last)


def test_for_whom(here, tmp_path, monkeypatch):
    robot = make_package(here / "robot", "robot")
    (robot / "launch").mkdir()
    launch = robot / "launch" / "a.launch"
    launch.write_text("<launch/>")
    for words in (["robot"], [str(robot)], [str(launch)], ["robot", "a.launch"]):
        assert add.deps.folders_of(words) == [str(robot)]
    for words in (["nothing"], [str(tmp_path / "none")], ["a.launch"]):
        with pytest.raises(UsageError, match=f"'{words[0]}' is no package"):
            add.deps.folders_of(words)


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
    program(tmp_path / "vcs", HALF.format(word))
    with monkeypatch.context() as patch:
        patch.setattr(repositories.deps, "VCS", str(tmp_path / "vcs"))
        with pytest.raises(error):
            repositories.bring(thing, str(sources))
    assert list(here.iterdir()) == []
    (here / repositories.PART / "thing").mkdir(parents=True)  # by SIGKILL
    (here / repositories.PART / "thing" / "half").touch()
    repositories.bring(thing, str(sources))
    assert sorted(path.name for path in here.iterdir()) == ["thing"]
    assert (here / "thing" / "package.xml").exists() and not (here / "thing" / "half").exists()


def test_two_at_once_wait_for_each_other(tmp_path, monkeypatch, capfd):
    """Both wrote the same list for vcstool: one repository was not brought, with exit status 0."""
    monkeypatch.setattr(add, "CACHE", str(tmp_path))
    monkeypatch.setattr(add.step, "SILENT", 0.0)
    asked = []
    monkeypatch.setattr(add, "add", lambda names, *_: asked.append(names))
    second = threading.Thread(target=cli.dispatch, args=(["add", "thing"],))
    with add.step.SetupLock(str(tmp_path / add.LOCK)):
        second.start()
        told, end = "", time.monotonic() + PATIENCE
        while not told and time.monotonic() < end:
            told = capfd.readouterr().err
            time.sleep(0.05)
        assert told.startswith("another ./run is bringing packages, waiting for it") and not asked
    second.join(PATIENCE)
    assert asked == [["thing"]]
