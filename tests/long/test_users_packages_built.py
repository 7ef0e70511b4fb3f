"""Packages that a user brings, built: they win over stand-ins, and building goes on."""

import json
import pathlib
import shutil
import subprocess

import pytest
from run_rig import ROOT, run
from users_rig import HEAD, INDEXED, of_type, package

from commands.bootstrap import left_out, old_code

OLD = """#include <boost/bind/bind.hpp>
#include <boost/program_options.hpp>
#include <iostream>
#include <string_view>
double half(double number) { return number / 2; }
int main(int count, char** words) {
  boost::program_options::options_description options("none");
  boost::filesystem::path path("a");
  std::cout << boost::bind(half, _1)(count) << std::string_view("") << options << path << std::endl;
}
"""
# Programs of it: one needs Gazebo, one does not, one does not compile, one is not linked.
MIXED = (
    HEAD.format("mixed", "")
    + "find_package(gazebo REQUIRED)\ncatkin_package()\n"
    + "include_directories(${catkin_INCLUDE_DIRS} ${GAZEBO_INCLUDE_DIRS})\n"
    + "link_directories(${GAZEBO_LIBRARY_DIRS})\n"
    + "".join(
        f"add_executable({name} src/{name}.cpp)\n"
        f"target_link_libraries({name} ${{GAZEBO_LIBRARIES}})\n"
        for name in ("good", "world", "wrong", "loose")
    )
)
SOURCES = {
    "good": "int main() { return 0; }\n",
    "world": "#include <gazebo/gazebo.hh>\nint main() { return 0; }\n",
    "wrong": "int main() { return no_such_name; }\n",
    "loose": "int far();\nint main() { return far(); }\n",
}


PLAIN = (
    "cmake_minimum_required(VERSION 3.5)\nproject({0} CXX)\n{1}"
    "add_library({0} SHARED src/{0}.cpp)\n"
    "install(TARGETS {0} EXPORT {0}Config LIBRARY DESTINATION lib)\n"
    "install(EXPORT {0}Config DESTINATION lib/cmake/{0})\n"
)


@pytest.fixture(scope="module")
def filled(clone, tmp_path_factory, package_index):
    """A small clone into which a user puts packages after its set-up, and the next set-up."""
    root = tmp_path_factory.mktemp("users") / "paddock"
    shutil.copytree(clone, root, symlinks=True)
    standins = root / "src" / "standins"
    shutil.copytree(ROOT / "src" / "standins" / "gazebo_dev", standins / "gazebo_dev")
    package(standins / "map_server", "map_server", HEAD.format("map_server", "")
            + "catkin_package()\n"
            "catkin_install_python(PROGRAMS src/map_server.cpp DESTINATION x)\n",
            map_server="#!/usr/bin/env python3\n")  # fmt: skip
    text = HEAD.format("shown_msgs", "COMPONENTS message_generation") + (
        "add_message_files(FILES Shown.msg)\ngenerate_messages()\ncatkin_package()\n"
    )
    message = package(standins / "shown_msgs", "shown_msgs", text) / "msg" / "Shown.msg"
    message.parent.mkdir()
    message.write_text("int8 number\n")
    text = HEAD.format("shows", "COMPONENTS shown_msgs")
    text += "catkin_package(CATKIN_DEPENDS shown_msgs)\n"
    asking = package(standins / "shows", "shows", text) / "package.xml"
    wanted = "<depend>shown_msgs</depend></package>"
    asking.write_text(asking.read_text().replace("</package>", wanted))
    before = run("setup", root=root, env=package_index.environment())
    assert before.returncode == 0, before.stdout
    chained = root.parent / "chained"
    package(chained / "src" / "map_server", "map_server",
            HEAD.format("map_server", "") + "find_package(gazebo REQUIRED)\ncatkin_package()\n"
            "add_executable(map_server src/main.cpp)\n",
            main="int main() { return 8; }\n")  # fmt: skip
    built = run("exec", "catkin_make", "-C", str(chained), root=root)
    assert built.returncode == 0, built.stdout + built.stderr
    package(root / "src" / "brought" / "map_server", "map_server",
            HEAD.format("map_server", "") + "catkin_package()\n"
            "add_executable(map_server src/main.cpp)\n",
            main="int main() { return 7; }\n")  # fmt: skip
    package(root / "src" / "mixed", "mixed", MIXED, **SOURCES)
    package(root / "src" / "needs_mixed", "needs_mixed",
            HEAD.format("needs_mixed", "COMPONENTS mixed no_such_thing"))  # fmt: skip
    package(root / "src" / "follows", "follows",
            HEAD.format("follows", "COMPONENTS needs_mixed") + "catkin_package()\n")  # fmt: skip
    package(root / "src" / "asks", "asks",
            HEAD.format("asks", "") + "find_package(NoSuchLibrary REQUIRED)\n")  # fmt: skip
    package(root / "src" / "old", "old",
            HEAD.format("old", "") + "add_compile_options(-std=c++11)\ncatkin_package()\n"
            "add_executable(old src/old.cpp)\n", old=OLD)  # fmt: skip
    own = HEAD.format("own_words", "COMPONENTS message_generation std_msgs") + (
        "add_message_files(FILES Word.msg)\ngenerate_messages(DEPENDENCIES std_msgs)\n"
        "catkin_package()\ninclude_directories(${catkin_INCLUDE_DIRS})\n"
        "add_executable(speak src/speak.cpp)\n"  # without add_dependencies
    )
    words = package(root / "src" / "own_words", "own_words", own,
                    speak="#include <own_words/Word.h>\nint main() { return 0; }\n")  # fmt: skip
    (words / "msg").mkdir()
    (words / "msg" / "Word.msg").write_text("string data\n")
    package(root / "src" / "hears", "hears",  # comes before own_words by name
            HEAD.format("hears", "COMPONENTS own_words") + "catkin_package()\n"
            "include_directories(${catkin_INCLUDE_DIRS})\nadd_executable(hear src/hear.cpp)\n"
            "catkin_add_gtest(hear_test src/hear.cpp)\ntarget_link_libraries(hear_test m)\n"
            "catkin_run_tests_target(a b c)\n",
            hear="#include <own_words/Word.h>\nint main() { return 0; }\n")  # fmt: skip
    package(root / "src" / "agv", "agv",  # comes before the stand-ins by name
            HEAD.format("agv", "COMPONENTS shows") + "catkin_package()\n"
            "include_directories(${catkin_INCLUDE_DIRS})\nadd_executable(agv src/agv.cpp)\n"
            "add_dependencies(agv ${catkin_EXPORTED_TARGETS})\n",
            agv="#include <shown_msgs/Shown.h>\nint main() { return 0; }\n")  # fmt: skip
    linked = "find_package(plain_sum REQUIRED)\nlink_libraries(plain_sum)\n"
    tested = "add_executable(sum_test src/sum_test.cpp)\nadd_test(NAME sum_test COMMAND sum_test)\n"
    installed = (
        "add_executable(half_test src/half_of_it.cpp)\nset_target_properties(half_test PROPERTIES "
        "LINK_FLAGS -shared)\nadd_test(half_test half_test)\n"
        "install(TARGETS half_test DESTINATION bin)\n"
    )
    for name, text, more in (
        ("plain_sum", "int sum() { return 5; }\n", tested),
        ("half_of_it", "int sum();\nint half() { return sum() / 2; }\n", linked + installed),
        ("bad_plain", "int bad() { return no_such_name; }\n", ""),
    ):
        sources = {name: text, "sum_test": "int main() { return no_such_name; }\n"}
        folder = package(root / "src" / name, name, PLAIN.format(name, more), **sources)
        of_type(folder, "cmake", *(["plain_sum"] if name == "half_of_it" else []))
    of_type(package(root / "src" / "of_ros_2", "of_ros_2", "error\n"), "ament_cmake")
    package(root / "src" / "uses_plain", "uses_plain",
            HEAD.format("uses_plain", "") + "catkin_package()\n"
            "find_package(plain_sum REQUIRED)\nfind_package(half_of_it REQUIRED)\n"
            "add_executable(uses src/uses.cpp)\ntarget_link_libraries(uses half_of_it)\n",
            uses="int half();\nint main() { return half(); }\n")  # fmt: skip
    package(root / "src" / "gazebo_ros", "gazebo_ros", HEAD.format("gazebo_ros", "") + "error\n")
    wrong = package(root / "src" / "wrong_mail", "wrong_mail", "error\n") / "package.xml"
    wrong.write_text(wrong.read_text().replace("a@example.org", "nobody"))
    done = run("setup", root=root, env=package_index.environment())
    return root, done


def test_a_users_package_takes_the_place_of_a_stand_in(filled):
    root, done = filled
    assert done.returncode == 0, done.stdout + done.stderr
    assert (root / "src" / "standins" / "map_server" / "CATKIN_IGNORE").exists()
    program = root / "devel" / "lib" / "map_server" / "map_server"
    assert program.read_bytes().startswith(b"\x7fELF")
    found = run("exec", "rospack", "find", "map_server", root=root)
    assert found.stdout == f"{root}/src/brought/map_server\n"


def test_a_chained_workspace_comes_first(filled):
    """It was built beside a stand-in, for find_package(gazebo), too."""
    root, _ = filled
    chained = root.parent / "chained" / "devel"
    words = (
        f". {chained}/setup.bash && {root}/run exec catkin_find --first-only --libexec map_server"
    )
    done = subprocess.run(["bash", "-c", words], capture_output=True, text=True, check=False)
    assert done.stdout == f"{chained}/lib/map_server\n", done.stderr


def test_what_cannot_be_built_is_named_and_the_rest_is_there(filled):
    root, done = filled
    lines = [line for line in done.stdout.splitlines() if line.startswith("left out: ")]
    said = "\n".join(lines)
    gazebo = f"left out: mixed (world): it includes Gazebo's gazebo/gazebo.hh; {left_out.GAZEBO}"
    assert gazebo in said
    assert "left out: mixed (wrong): wrong.cpp:1: 'no_such_name' was not declared" in said
    assert "left out: mixed (loose): undefined reference to `far()'" in said
    assert "left out: needs_mixed: it needs no_such_thing; " in said
    assert "left out: follows: it needs needs_mixed, which is left out" in said
    assert "left out: asks: it needs NoSuchLibrary; " in said
    assert "left out: bad_plain: bad_plain.cpp:1: 'no_such_name' was not declared" in said
    assert "left out: of_ros_2: its build type is ament_cmake, " in said
    assert "left out: wrong_mail: catkin refuses src/wrong_mail/package.xml: " in said
    assert len(lines) == 9, said
    built = {path.name for path in (root / "devel" / "lib").glob("*/*")}
    assert {"agv", "good", "hear", "old", "speak", "map_server"} <= built and not {
        "world",
        "wrong",
    } & built
    assert run("exec", "rospack", "find", "asks", root=root).stdout == f"{root}/src/asks\n"


def test_old_code_is_helped_and_said_so(filled):
    _, done = filled
    helped = [line for line in done.stdout.splitlines() if line.startswith("old is built with ")]
    assert len(helped) == 1
    assert "placeholders" in helped[0] and "libboost_program_options" in helped[0]
    assert ("C++ 17" in helped[0]) == old_code._needs_standard()


def test_plain_cmake_is_built_before_what_asks_for_it(filled):
    root, _ = filled
    assert run("exec", f"{root}/devel/lib/uses_plain/uses", root=root).returncode == 2
    assert run("exec", "rospack", "find", "of_ros_2", root=root).stdout.endswith("/of_ros_2\n")


def test_the_stand_in_of_what_needs_gazebo_stays(filled):
    root, done = filled
    assert "not built: src/gazebo_ros: it needs Gazebo itself, ours is used\n" in done.stdout
    assert (root / "src" / "gazebo_ros" / "CATKIN_IGNORE").read_text().startswith("by ./run: ")


def test_it_is_said_again_and_not_built_again(filled):
    root, _ = filled
    again = run("setup", root=root)
    assert again.returncode == 0 and "Workspace" not in again.stdout
    assert again.stdout.count("left out: ") == 9


def test_stand_ins_come_back_with_the_users_package_gone(filled, package_index):
    root, _ = filled
    for name in (
        *("brought", "mixed", "needs_mixed", "follows", "asks", "old", "own_words", "hears"),
        *("plain_sum", "half_of_it", "bad_plain", "of_ros_2", "uses_plain", "wrong_mail"),
    ):
        shutil.rmtree(root / "src" / name)
    done = run("exec", "rospack", "find", "map_server", root=root)
    assert done.stdout.endswith(f"{root}/src/standins/map_server\n"), done.stdout + done.stderr
    assert left_out_of(root) == []


def left_out_of(root):
    """What the last build of a clone has left out."""
    return json.loads((pathlib.Path(root) / "build" / ".left_out").read_text())


def test_a_failure_of_ours_ends_the_set_up(filled, package_index):
    root, _ = filled
    (root / "src" / "paddock_common").mkdir()
    package(root / "src" / "paddock_common" / "x", "paddock_common",
            HEAD.format("paddock_common", "") + "catkin_package()\nadd_executable(x src/x.cpp)\n",
            x="int main() { return no_such_name; }\n")  # fmt: skip
    done = run("setup", root=root)
    assert done.returncode == 1 and "no_such_name" in done.stdout
    assert "run: the step 'Workspace' failed" in done.stderr


def test_a_clone_is_filled(clone, tmp_path, sources, package_index):
    root = tmp_path / "paddock"
    shutil.copytree(clone, root, symlinks=True)
    with (root / "config" / "sources" / "more.txt").open("a") as known:
        known.write(INDEXED)
    options = {"root": root, "env": package_index.environment()}
    done = run("add", "--from", str(sources), "thing", "packed", **options)
    assert done.returncode == 0, done.stdout + done.stderr
    end = "here now: packed, thing\n"
    assert done.stdout.endswith(end), done.stdout
    for name in ("thing", "packed"):
        assert (root / "devel" / "share" / name / "cmake" / f"{name}Config.cmake").exists()
    again = run("add", "--from", str(sources), "thing", **options)
    assert "src/thing is there already, and stays as it is\n" in again.stdout
    assert "here now: nothing new\n" in again.stdout
    wrong = run("add", f"file://{sources}/nowhere.git", **options)
    assert wrong.returncode == 1 and "nowhere.git cannot be brought" in wrong.stderr
    assert not (root / "src" / "nowhere").exists()
