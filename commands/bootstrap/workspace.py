"""Steps 3 and 4: the catkin workspace in build/ and devel/, and the solver's library.

What makes a build necessary, and how it is made.
"""

import glob
import os

from commands import signature
from commands.bootstrap import ros
from commands.bootstrap.step import Step
from commands.paths import BUILD, DEVEL, ROOT, SOURCES, SYSTEM_PATH, VENV, VENV_PYTHON, read, write

STANDINS = os.path.join(SOURCES, "standins")
NAMES = ("CMakeLists.txt", "package.xml", "setup.py", "CATKIN_IGNORE")
SUFFIXES = (".msg", ".srv", ".action", ".cfg", ".cmake", ".in", ".cpp", ".h")
SIMULATOR = ("gazebo_ros",)  # its launch files start the simulator: always ours
ALWAYS_FOUND = ("xacro",)  # though not built: $(find xacro)/xacro.py of old launch files
SKIPPED = ("build", "devel", "install")  # by catkin ...
IGNORE = ("CATKIN_IGNORE", "AMENT_IGNORE")  # ... as are folders with one of these
MARKER, MARK = "CATKIN_IGNORE", "by ./run: the ROS has this package\n"
LISTED = ("nodes", "scripts")  # folders whose files are linked or wrapped by the build
GENERATED = os.path.join(SOURCES, "CMakeLists.txt")  # by catkin_make
STAMP = os.path.join(BUILD, ".stamp")  # the key of a complete build
BUILT_AT = os.path.join(BUILD, ".root")
BUILT = os.path.join(BUILD, ".packages")
SETUP = os.path.join(DEVEL, "setup.bash")
# Other workspaces and compilers of the caller's environment have no part in the build, unless the
# ROS is that of a conda environment, which is built with that environment's compilers.
LEFT_OUT = (
    "CMAKE_PREFIX_PATH",
    "ROS_PACKAGE_PATH",
    "PYTHONPATH",
    "PYTHONHOME",
)
SOLVER = os.path.join(SOURCES, "bullet_sim/src/bullet_sim/engine/quickstep")
LAW = os.path.join(SOURCES, "bullet_sim/src/bullet_sim/controllers/law.py")  # compiled with it
# Run by .venv's Python with the path of bullet_sim's sources. Of its packages only what is compiled
# is imported: the rest needs PyBullet, which may not be there yet.
COMPILE = """
import sys, types
for name in ("bullet_sim.engine", "bullet_sim.controllers"):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [f"{sys.argv[1]}/{name.replace('.', '/')}"]
from bullet_sim.engine.quickstep import sources
if not sources.library_path().is_file():  # sources with new dates may be the same
    from bullet_sim.engine.quickstep import entries
    entries.main()
"""
COMPILERS = ("CC", "CXX", "CFLAGS", "CXXFLAGS", "LDFLAGS")


def installed_elsewhere():
    """Lists stand-ins whose real package the ROS has; they are left out of the build."""
    names = sorted(os.listdir(STANDINS)) if os.path.isdir(STANDINS) else []
    return [name for name in names if name not in SIMULATOR and in_ros(name)]


def hide():
    """Hides the stand-ins that are left out from rospack and $(find), which search the sources."""
    hidden = set(installed_elsewhere()) - set(ALWAYS_FOUND)
    for name in os.listdir(STANDINS) if os.path.isdir(STANDINS) else []:
        if not os.path.isdir(os.path.join(STANDINS, name)):
            continue
        marker = os.path.join(STANDINS, name, MARKER)
        if name in hidden and not os.path.exists(marker):
            write(marker, MARK)
        elif name not in hidden and read(marker) == MARK:  # one by hand stays
            os.remove(marker)


def manifests_below(folder):
    """Lists the package.xml files at and below a folder, as catkin finds them."""
    found = []
    for directory, below, files in os.walk(folder):
        if any(name in files for name in IGNORE):
            below[:] = []
        elif "package.xml" in files:
            found.append(os.path.join(directory, "package.xml"))
            below[:] = []
        else:
            below[:] = sorted(n for n in below if not n.startswith(".") and n not in SKIPPED)
    return found


def in_ros(name):
    """Returns whether the ROS below has a package."""
    return os.path.exists(f"{ros.share()}/{name}/package.xml")


def scan():
    """Walks the sources.

    Returns:
        directories: Every directory, as nothing can come or go without changing one of them.
        inputs: Files whose content counts.
        names: Files whose presence counts.
    """
    directories, inputs, names = [], [], []
    for directory, subdirectories, files in os.walk(SOURCES):
        subdirectories[:] = sorted(name for name in subdirectories if name != "__pycache__")
        directories.append(directory)
        listed = any(name in LISTED for name in os.path.relpath(directory, ROOT).split(os.sep))
        for name in sorted(files):
            path = os.path.join(directory, name)
            built_from = name in NAMES or name.endswith(SUFFIXES)
            installed = (listed or name == "__init__.py") and not name.endswith(".pyc")
            if not (built_from or installed) or os.path.islink(path) or path == GENERATED:
                continue
            if built_from:
                inputs.append(path)
            if installed:
                names.append(path)
    return directories, inputs, names


def build_key(inputs, names):
    """Returns one text for everything that a build depends on.

    Args:
        inputs: Files whose content counts.
        names: Files whose presence counts.
    """
    import hashlib

    whole = hashlib.sha256("\n".join([*_base(), *names]).encode())
    for path in inputs:
        with open(path, "rb") as stream:
            content = hashlib.sha256(stream.read()).hexdigest()
        whole.update(f"\n{content} {path}".encode())
    return whole.hexdigest()


def list_packages(inputs):
    """Lists the workspace's packages: the folders of package.xml, relative to the clone."""
    return sorted(
        os.path.relpath(os.path.dirname(path), ROOT)
        for path in inputs
        if os.path.basename(path) == "package.xml"
    )


def _base():
    """Lists what else a build is bound to: the place of the clone, the ROS, what that has."""
    return [ROOT, *filter(None, [ros.prefix()]), *installed_elsewhere()]


def _complete(inputs, names):
    return os.path.exists(SETUP) and read(STAMP).strip() == build_key(inputs, names)


def ready():
    """Returns whether there is nothing to build."""
    return (_is_unchanged() or _complete(*scan()[1:])) and _is_compiled()


def _is_unchanged():
    return signature.unchanged("workspace", ";".join(_base()))


def steps(changing):
    """Gives the steps that build what has changed.

    Args:
        changing: Whether packages come or .venv changes; what is to be built is seen after that.
    """
    found = []
    if changing or not _is_unchanged():
        advice = "The lines above name the package. To build from scratch: rm -rf build devel"
        found.append(Step(3, "Workspace", _build_workspace, advice, "build_workspace"))
    if changing or not _is_compiled():
        found.append(Step(4, "Solver", _compile, "The lines above say why.", "compile_solver"))
    return found


def _build_workspace(step):
    yield "packages"
    yield "venv"
    if _is_unchanged():
        return
    directories, inputs, names = scan()
    if not _complete(inputs, names):
        yield from _build(step)
        directories, inputs, _ = scan()
    signature.save("workspace", ";".join(_base()), [STAMP, SETUP, *directories, *inputs])


def _is_compiled():
    """Returns whether the solver was compiled since its sources changed; without numba: True."""
    sources = [*glob.glob(f"{SOLVER}/*.py"), *glob.glob(LAW)]
    changed = max((os.stat(path).st_mtime for path in sources), default=0.0)
    built = f"{SOLVER}/__pycache__/sources.built"
    if os.path.exists(built) and os.stat(built).st_mtime >= changed:
        return True
    return not glob.glob(f"{VENV}/lib/python3*/site-packages/numba")


def _compile(_step):
    """Compiles the solver of the simulator, which else does so at its start."""
    yield "numba"
    if _is_compiled():
        return
    sources = f"{SOURCES}/bullet_sim/src"
    environ = {"PATH": SYSTEM_PATH, "PYTHONPATH": sources, "PYTHONNOUSERSITE": "1"}
    yield [VENV_PYTHON, "-c", COMPILE, sources], environ
    write(f"{SOLVER}/__pycache__/sources.built", "")  # with its library, or for want of a linker


def _build(_step):
    hide()
    _, inputs, names = scan()
    packages = list_packages(inputs)
    gone = set(read(BUILT).split("\n")[:-1]) - set(packages)
    folder = ros.prefix()
    built_at = f"{ROOT} {folder}".rstrip()
    # A moved clone, another ROS, or a package that is gone: what was built before would mislead.
    if read(BUILT_AT).strip() != built_at or gone:
        import shutil

        if os.path.exists(BUILT_AT):
            os.remove(BUILT_AT)  # first: half of a build that is deleted is none
        for directory in (BUILD, DEVEL):
            if os.path.isdir(directory):
                shutil.rmtree(directory)
    write(BUILT_AT, f"{built_at}\n")
    if os.path.exists(STAMP):
        os.remove(STAMP)
    write(BUILT, "".join(f"{name}\n" for name in packages))
    key = build_key(inputs, names)
    left_out = (*LEFT_OUT, *(() if os.path.isdir(f"{folder}/conda-meta") else COMPILERS))
    environ = {name: value for name, value in os.environ.items() if name not in left_out}
    environ["PATH"] = SYSTEM_PATH
    ros.enter(environ, folder)
    environ.pop("ROS_DISTRO", None)  # catkin fails where it is another one than the ROS sets
    environ.update(PATH=f"{VENV}/bin:{environ['PATH']}", PYTHONNOUSERSITE="1", VIRTUAL_ENV=VENV)
    yield (
        [
            "catkin_make",
            "-C",
            ROOT,
            f"-j{len(os.sched_getaffinity(0))}",
            f"-DPYTHON_EXECUTABLE={VENV_PYTHON}",
            f"-DCMAKE_PREFIX_PATH={environ.get('CMAKE_PREFIX_PATH', '').replace(':', ';')}",
            "-DCMAKE_BUILD_TYPE=Release",
            "-DCATKIN_ENABLE_TESTING=OFF",
            "-DCATKIN_BLACKLIST_PACKAGES=" + ";".join(installed_elsewhere()),
        ],
        environ,
    )
    write(STAMP, f"{key}\n")
