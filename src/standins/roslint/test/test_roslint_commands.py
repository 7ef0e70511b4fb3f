"""Every way to call the commands configures, and the targets of the usual names build."""

import os
import shutil
import subprocess

EXTRAS = os.path.join(
    os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "cmake", "roslint-extras.cmake"
)
PROJECT = """
cmake_minimum_required(VERSION 3.0.2)
project(some_car NONE)
include("{extras}")
roslint_cpp()
roslint_cpp(src/a.cpp include/a.h)
roslint_python()
roslint_python(nodes/a)
roslint_custom(some_linter "--strict;--all" src/a.cpp)
roslint_add_test()
"""


def test_commands_make_targets_that_check_nothing(tmp_path):
    cmake = shutil.which("cmake")
    assert cmake, "cmake is not installed"
    (tmp_path / "CMakeLists.txt").write_text(PROJECT.format(extras=EXTRAS))
    for command in (
        [cmake, "-S", str(tmp_path), "-B", str(tmp_path / "build")],
        [cmake, "--build", str(tmp_path / "build"), "--target", "roslint"],
        [cmake, "--build", str(tmp_path / "build"), "--target", "roslint_some_car"],
    ):
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
