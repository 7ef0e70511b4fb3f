"""Packages that a user puts into src/: how each is looked at before it is built."""

import os
import shutil
import subprocess

import pytest
from run_rig import ROOT
from users_rig import HEAD, of_type, package

from commands.bootstrap import left_out, old_code, plain_cmake, workspace
from commands.subcommands import deps, setup


def test_folders_of_ours_are_all_that_the_repository_has():
    found = {path.parent.name for path in (ROOT / "src").glob("*/package.xml")}
    assert set(workspace.OURS) - {"standins"} <= found
    for name in workspace.OURS:
        assert (ROOT / "src" / name).is_dir()


@pytest.mark.parametrize(
    "cmake, source, needs",
    [
        ("", "x = boost::bind(&A::b, this, _1);", ["placeholders"]),
        ("", "x = boost::bind(&A::b, this,\n    _1, 3);", ["placeholders"]),
        ("", "#include <boost/bind.hpp>\nx = boost::bind(&A::b, _1);", []),
        ("", "using namespace std::placeholders;\nx = std::bind(&A::b, _1);", []),
        ("", "x = std::bind(&A::b, std::placeholders::_1);", []),
        ("", "x = boost::bind(&A::b, this); y = name_1;", []),
        ("find_package(Boost program_options)", "#include <boost/program_options.hpp>", []),
        ("", "#include <boost/filesystem/path.hpp>", ["boost_filesystem"]),
        ("", "boost::filesystem::path p;", ["include_filesystem", "boost_filesystem"]),
        ("filesystem", "boost::filesystem::path p;", ["include_filesystem"]),
        ("", "#include <Eigen/Dense>\nm(std::round(x)) += 1;", ["eigen"]),
        ("", "#include <Eigen/Dense>\nm[i](round(x)) += 1;", ["eigen"]),
        ("", "#include <Eigen/Dense>\nint(round(x)) + std::max(floor(x), 1) + (ceil(x));", []),
        ("", "m(round(x)) += 1;", []),
        ("", "class A : google::LogSink { void send(const struct std::tm* t); };", ["glog"]),
        ("", "class A : google::LogSink {};", []),
        ("# -std=c++11", "", []),
        ("find_package(Protobuf REQUIRED)\nfind_package(gazebo)", "", ["protobuf"]),
        ("find_package(Protobuf REQUIRED)", "", []),
        ("", "#include <libavcodec/avcodec.h>\nAVCodec* codec;", ["ffmpeg"]),
        ("", "#include <libavcodec/avcodec.h>\nconst AVCodec *codec;", []),
        ("", "#include <libavcodec/avcodec.h>\nav_register_all();", ["ffmpeg"]),
        ("", "#include <libavcodec/avcodec.h>\nint lock(void **, enum AVLockOp);", ["ffmpeg"]),
        ("", "AVCodec *codec;", []),
    ],
)  # fmt: skip
def test_what_old_code_needs(tmp_path, monkeypatch, cmake, source, needs):
    (tmp_path / "logging.h").write_text("struct LogMessageTime;\n")
    monkeypatch.setattr(old_code, "GLOG", str(tmp_path / "logging.h"))
    folder = package(tmp_path / "old", "old", HEAD.format("old", "") + cmake, old=source)
    assert old_code.needs_of(str(folder)) == needs


def test_what_a_header_needs_is_given_to_what_includes_it(tmp_path):
    """nav_core_adapter includes nav_2d_utils' odom_subscriber.h, which has a bare _1."""
    bare, plain = "x = boost::bind(&A::b, this, _1);", "int x;"
    standard = "using namespace std::placeholders;"
    folders = {}
    for name, source, header, wanted in (
        ("header", plain, bare, ""),
        ("source", bare, plain, ""),
        ("uses", plain, plain, "header"),
        ("above", plain, plain, "uses"),
        ("standards", standard, plain, "header"),
        ("others", plain, plain, "source"),
    ):
        folder = package(tmp_path / name, name, HEAD.format(name, ""), **{name: source})
        (folder / "include" / name).mkdir(parents=True)
        (folder / "include" / name / "a.h").write_text(header)
        manifest = folder / "package.xml"
        depend = f"<depend>{wanted}</depend></package>" if wanted else "</package>"
        manifest.write_text(manifest.read_text().replace("</package>", depend))
        folders[name] = str(folder)
    needs = old_code.with_headers(folders)
    helped = {name for name, needed in needs.items() if needed == ["placeholders"]}
    assert helped == {"header", "source", "uses", "above"}
    assert needs["standards"] == needs["others"] == []


def test_what_was_left_out_is_built_again_when_old_code_is_helped_otherwise(tmp_path, monkeypatch):
    """After a git pull it stayed left out until something of it changed."""
    helper = tmp_path / "helper.h"
    monkeypatch.setattr(old_code, "HEADERS", str(tmp_path))
    assert old_code.HOOK in old_code.helpers()
    seen = []
    for saved, text in ((["p"], ""), (["p"], "new"), ([], ""), ([], "new")):
        monkeypatch.setattr(left_out, "saved", lambda saved=saved: saved)
        helper.write_text(text)
        os.utime(helper, ns=(1, len(seen) + 1))
        seen.append(workspace._base())
    assert seen[0] != seen[1] and seen[2] == seen[3]


def test_what_counts_on_noetics_pluginlib_gets_its_header(tmp_path, monkeypatch):
    """In qt_gui_cpp's header, which other packages and sip's own make compile, too."""
    monkeypatch.setattr(old_code, "HELP", str(tmp_path / "help.cmake"))
    monkeypatch.setattr(old_code, "DEBIANS_PLUGINLIB", __file__)
    loader, path = "#include <pluginlib/class_loader.hpp>\n", "boost::filesystem::path p;\n"
    for source, helped in ((loader + path, True), (loader, False), (path, False)):
        folder = package(tmp_path / "old", "old", HEAD.format("old", ""), old=source)
        old_code.prepare({"old": str(folder)}, {})
        assert ("set(pluginlib_DIR " in (tmp_path / "help.cmake").read_text()) == helped
        shutil.rmtree(folder)


def test_build_types(tmp_path):
    packages = {}
    for name, kind in (("plain", "cmake"), ("other", "ament_python"), ("usual", "catkin")):
        packages[name] = package(tmp_path / name, name, "")
        of_type(packages[name], kind)
    packages["none"] = package(tmp_path / "none", "none", "")
    packages["both"] = package(tmp_path / "both", "both", "")
    manifest = packages["both"] / "package.xml"
    for version, kind in ((1, "catkin"), (2, "ament_cmake")):
        end = f'<build_type condition="$ROS_VERSION == {version}">{kind}</build_type></export>'
        text = manifest.read_text()
        if "<export>" not in text:
            text = text.replace("</package>", "<export></export></package>")
        manifest.write_text(text.replace("</export>", end))
    assert plain_cmake.foreign(packages) == {"plain": "cmake", "other": "ament_python"}


@pytest.mark.parametrize(
    "old, new, why",
    [
        ("a@example.org", "a at example", 'Invalid email "a at example"'),
        (' email="a@example.org"', "", 'must have the attribute "email"'),
        ("1.0.0", "one", 'version "one" does not follow'),
        ('<maintainer email="a@example.org">a</maintainer>', "", "at least one maintainer"),
        ('format="2"', 'format="9"', "format version '9'"),
        ('format="2"', 'format="new"', "'new'"),
        ("<name>p</name>", "", 'exactly one "name" tag'),
        ("<license>", "<licence>", "invalid XML"),
        ("<license>", "<strange/><license>", "must not contain the following tags: strange"),
        ("<description>x", "<description>\udcff", "'utf-8' codec can't decode"),
        ("<package", "<!-- -- --><package", "invalid XML"),
        (None, "", "invalid XML"),
    ],
)
def test_a_package_that_catkin_refuses_is_left_out_and_named(tmp_path, monkeypatch, old, new, why):
    """Each failed every ./run."""
    monkeypatch.setattr(workspace, "SOURCES", str(tmp_path))
    good, bad = (package(tmp_path / name, name, "") for name in ("good", "p"))
    manifest = bad / "package.xml"
    text = manifest.read_text()
    changed = text.replace(old, new) if old else new
    manifest.write_bytes(changed.encode(errors="surrogateescape"))
    (entry,) = workspace._refuse(None)
    assert entry.package in ("p", str(bad)) and why in entry.cause
    assert workspace.users_packages() == {"good": str(good)}
    assert workspace.scan()[1].count(str(manifest)) == 1  # when it is mended, it is built
    assert (
        next(iter(deps.readable([f"{good}/package.xml", str(manifest)]))) == f"{good}/package.xml"
    )
    plain_cmake.foreign({"p": str(bad)})
    manifest.write_text(text)
    assert workspace._refuse(None) == [] and not (bad / workspace.MARKER).exists()
    assert set(workspace.users_packages()) == {"good", "p"}


@pytest.mark.parametrize("free, jobs", [(100, 1), (1_500_000, 1), (3_100_000, 2), (9e8, 4)])
def test_as_many_compilers_as_memory_is_free(tmp_path, monkeypatch, free, jobs):
    monkeypatch.setattr(plain_cmake.os, "sched_getaffinity", lambda _: range(4), raising=False)
    (tmp_path / "meminfo").write_text(f"MemFree: 1 kB\nMemAvailable:  {free:.0f} kB\n")
    assert plain_cmake.jobs(str(tmp_path / "meminfo")) == f"-j{jobs}"
    assert plain_cmake.jobs(str(tmp_path / "none")) == "-j4"


def test_messages_that_a_package_forgets_to_ask_for(tmp_path):
    text = HEAD.format("words", "COMPONENTS message_generation") + "generate_messages()\n"
    folders = {"words": package(tmp_path / "words", "words", text)}
    for name in ("asks", "follows", "forgets"):
        text = HEAD.format(name, "COMPONENTS roscpp words")
        folders[name] = package(tmp_path / name, name, text)
    for name, wanted in (("asks", "words"), ("follows", "asks")):
        manifest = folders[name] / "package.xml"
        depend = f"<depend>{wanted}</depend></package>"
        manifest.write_text(manifest.read_text().replace("</package>", depend))
    packages = {name: str(folder) for name, folder in folders.items()}
    assert [old_code.forgotten(name, packages) for name in ("asks", "follows", "forgets")] == [
        [], [], ["words"],
    ]  # fmt: skip


ORDERED = """cmake_minimum_required(VERSION 3.1)
project(Project NONE)
function(catkin_workspace)
  set(CATKIN_ORDERED_PACKAGES agv own ours theirs)
  set(CATKIN_ORDERED_PACKAGE_PATHS u/agv u/own ours u/theirs)
  set(CATKIN_ORDERED_PACKAGES_IS_META False False True False)
  set(CATKIN_ORDERED_PACKAGES_BUILD_TYPE catkin catkin catkin cmake)
  set(CATKIN_METAPACKAGE_CMAKE_TEMPLATE x)
  message(STATUS "${CATKIN_ORDERED_PACKAGES}|${CATKIN_ORDERED_PACKAGE_PATHS}")
  message(STATUS "${CATKIN_ORDERED_PACKAGES_IS_META}|${CATKIN_ORDERED_PACKAGES_BUILD_TYPE}")
endfunction()
catkin_workspace()
"""


def test_what_is_configured_first_asks_for_nothing_else(tmp_path, monkeypatch):
    """Catkin's order, in its lists; here a stand-in asks for a package of the user."""
    monkeypatch.setattr(old_code, "HELP", str(tmp_path / "help.cmake"))
    names = ("agv", "own", "ours", "theirs")
    folders = {name: package(tmp_path / name, name, HEAD.format(name, "")) for name in names}
    manifest = folders["ours"] / "package.xml"
    manifest.write_text(manifest.read_text().replace("</pac", "<depend>own</depend></pac"))
    workspace = {name: str(folder) for name, folder in folders.items()}
    users = {name: workspace[name] for name in names if name != "ours"}
    old_code.prepare(users, workspace)
    (tmp_path / "CMakeLists.txt").write_text(ORDERED)
    words = ["cmake", str(tmp_path), *old_code.options()]
    done = subprocess.run(words, cwd=tmp_path, check=True, capture_output=True, text=True)
    assert "-- own;ours;agv;theirs|u/own;ours;u/agv;u/theirs\n" in done.stdout
    assert "-- False;True;False;False|catkin;catkin;catkin;cmake\n" in done.stdout


@pytest.mark.parametrize("major, needs", [(0, []), (1, ["standard"])])
def test_older_standards_are_left_where_log4cxx_takes_them(tmp_path, monkeypatch, major, needs):
    header = tmp_path / "ros" / "include" / "log4cxx" / "log4cxx.h"
    header.parent.mkdir(parents=True)
    header.write_text(f"#define LOG4CXX_VERSION_MAJOR {major}\n")
    monkeypatch.setattr(old_code.ros, "prefix", lambda: str(tmp_path / "ros"))
    for line in ("add_compile_options(-std=c++11)", "set(CMAKE_CXX_STANDARD 14)"):
        shutil.rmtree(tmp_path / "old", ignore_errors=True)
        folder = package(tmp_path / "old", "old", HEAD.format("old", "") + line)
        assert old_code.needs_of(str(folder)) == needs


def test_without_a_terminal_debian_packages_are_installed_after_they_are_named(monkeypatch):
    assert setup.asked("Install them?")  # as those of Paddock itself


def test_components_that_are_asked_for_only_sometimes_refuse_nothing(tmp_path):
    text = HEAD.format("a", "COMPONENTS roscpp") + (
        "if(CATKIN_ENABLE_TESTING)\n  find_package(catkin REQUIRED COMPONENTS rostest)\nendif()\n"
    )
    folder = package(tmp_path / "a", "a", text)
    assert left_out.before_configuration({"a": str(folder)}, {"roscpp"}.__contains__) == []
    (entry,) = left_out.before_configuration({"a": str(folder)}, set().__contains__)
    assert (entry.package, entry.missing) == ("a", "roscpp")
    assert "./run deps names" in entry.remedy


def test_a_component_that_can_be_added_is_named_with_the_command(tmp_path):
    folder = package(tmp_path / "a", "a", HEAD.format("a", "COMPONENTS robot_localization"))
    (entry,) = left_out.before_configuration({"a": str(folder)}, set().__contains__)
    assert entry.line() == (
        "left out: a: it needs robot_localization; ./run add robot_localization"
    )


LACKS_HEADER = """\
/w/src/mixed/src/a.cpp:1:10: fatal error: {}: No such file or directory
make[2]: *** [mixed/CMakeFiles/world.dir/build.make:76: mixed/CMakeFiles/world.dir/src/a.cpp.o] \
Error 1
make[1]: *** [CMakeFiles/Makefile2:99: mixed/CMakeFiles/world.dir/all] Error 2
"""


@pytest.mark.parametrize(
    "header, cause, missing",
    [
        ("gazebo/gazebo.hh", "it includes Gazebo's {}", ""),
        ("hardware_interface/robot_hw.h", "it includes ros_control's {}", ""),
        ("no_such_thing/a.h", "it includes {}", "no_such_thing"),
    ],
)
def test_a_program_that_lacks_a_header_is_left_out_with_whose_it_is(header, cause, missing):
    (entry,) = left_out.of_build(LACKS_HEADER.format(header), {"mixed": "mixed"})
    assert (entry.package, entry.program, entry.missing) == ("mixed", "world", missing)
    assert entry.cause == cause.format(header)


FINDS_G2O = """cmake_minimum_required(VERSION 3.1)
project(band NONE)
find_library(G2O_INCREMENTAL_LIB g2o_incremental)
set(found "/lib/libg2o_core.so" ${G2O_INCREMENTAL_LIB})
if(found)
  message(STATUS "libraries: ${found}")
endif()
"""


@pytest.mark.parametrize("built", [True, False])
def test_g2o_is_found_without_the_library_of_its_examples(tmp_path, built):
    (tmp_path / "lib").mkdir()
    (tmp_path / "help.cmake").write_text("")
    (tmp_path / "CMakeLists.txt").write_text(FINDS_G2O)
    if built:
        (tmp_path / "lib" / "libg2o_core.so").write_text("")
    words = [f"-DCMAKE_PROJECT_INCLUDE={old_code.HOOK}", f"-DPADDOCK_HELP={tmp_path}/help.cmake"]
    done = subprocess.run(
        ["cmake", str(tmp_path), *words, f"-DCATKIN_DEVEL_PREFIX={tmp_path}"],
        cwd=tmp_path / "lib", check=True, capture_output=True, text=True,
    )  # fmt: skip
    assert ("-- libraries: /lib/libg2o_core.so\n" in done.stdout) == built


def test_what_is_left_out_is_said_once(monkeypatch):
    """By the build, and not again by the command that has built."""
    monkeypatch.setattr(left_out, "_reported", set())
    one, other = (left_out.LeftOut(name, "", "it needs no_such_thing") for name in ("a", "b"))
    assert left_out.lines([one]) == ["left out: a: it needs no_such_thing"]
    assert left_out.lines([left_out.LeftOut(**vars(one)), other]) == [other.line()]


@pytest.mark.parametrize(
    "library, remedy",
    [
        ("gazebo_ros_kobuki", left_out.OF_PADDOCK),
        ("roboticsgroup_upatras_gazebo_mimic_joint_plugin", left_out.OF_PADDOCK),
        ("gazebo_ros_kobuk", left_out.GAZEBO),
        ("servo", left_out.GAZEBO),  # a word of Paddock's files, and no library
        ("ray", left_out.GAZEBO),
    ],
)
def test_a_plugin_that_paddock_has_itself_needs_no_libraries_of_gazebo(library, remedy):
    log = LACKS_HEADER.format("gazebo/gazebo.hh").replace("world", library)
    [entry] = left_out.of_build(log, {"mixed": "mixed"})
    assert (entry.program, entry.remedy) == (library, remedy)
