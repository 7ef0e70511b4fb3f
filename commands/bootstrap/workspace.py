"""Step 3, the catkin workspace: build/ and devel/."""

import os

from commands import signature
from commands.bootstrap import inputs
from commands.paths import BUILD, DEVEL, ROOT, SYSTEM_PATH, VENV, VENV_PYTHON, read, write

STAMP = os.path.join(BUILD, ".stamp")  # the key of a complete build
BUILT_AT = os.path.join(BUILD, ".root")
BUILT = os.path.join(BUILD, ".packages")
SETUP = os.path.join(DEVEL, "setup.bash")
# Other workspaces and compilers of the caller's environment have no part in the build.
LEFT_OUT = (
    "CMAKE_PREFIX_PATH",
    "ROS_PACKAGE_PATH",
    "PYTHONPATH",
    "PYTHONHOME",
    "CC",
    "CXX",
    "CFLAGS",
    "CXXFLAGS",
    "LDFLAGS",
)


def prepare():
    """Builds if an input changed.

    Raises:
        CommandError: The build failed.
        Interrupted: A signal ended it.
    """
    short_key = ";".join([ROOT, *inputs.installed_elsewhere()])
    if signature.unchanged("workspace", short_key):
        return
    directories, contents, names = inputs.scan()
    if not os.path.exists(SETUP) or read(STAMP).strip() != inputs.build_key(contents, names):
        from commands.bootstrap.step import Step

        Step(
            3,
            "Workspace",
            "The lines above name the package. To build from scratch: rm -rf build devel",
            "build_workspace",
        ).run(_build)
        directories, contents, _ = inputs.scan()
    signature.save("workspace", short_key, [STAMP, SETUP, *directories, *contents])


def _build(step):
    _, contents, names = inputs.scan()
    packages = inputs.packages(contents)
    gone = set(read(BUILT).split("\n")[:-1]) - set(packages)
    # A moved clone, or a package that is gone: what was built before would mislead.
    if read(BUILT_AT).strip() != ROOT or gone:
        import shutil

        if os.path.exists(BUILT_AT):
            os.remove(BUILT_AT)  # first: half of a build that is deleted is none
        for directory in (BUILD, DEVEL):
            if os.path.isdir(directory):
                shutil.rmtree(directory)
    write(BUILT_AT, f"{ROOT}\n")
    if os.path.exists(STAMP):
        os.remove(STAMP)
    write(BUILT, "".join(f"{name}\n" for name in packages))
    key = inputs.build_key(contents, names)
    environ = {name: value for name, value in os.environ.items() if name not in LEFT_OUT}
    environ.update(PATH=f"{VENV}/bin:{SYSTEM_PATH}", PYTHONNOUSERSITE="1", VIRTUAL_ENV=VENV)
    step.execute(
        [
            "catkin_make",
            "-C",
            ROOT,
            f"-j{len(os.sched_getaffinity(0))}",
            f"-DPYTHON_EXECUTABLE={VENV_PYTHON}",
            "-DCMAKE_PREFIX_PATH=",
            "-DCMAKE_BUILD_TYPE=Release",
            "-DCATKIN_ENABLE_TESTING=OFF",
            "-DCATKIN_BLACKLIST_PACKAGES=" + ";".join(inputs.installed_elsewhere()),
        ],
        environ,
    )
    write(STAMP, f"{key}\n")
