"""Steps 3 and 4: the catkin workspace in build/ and devel/, and the solver's library.

What makes a build necessary, and how it is made.
"""

import glob
import os

from commands import signature
from commands.bootstrap import left_out, old_code, packages, plain_cmake, ros
from commands.bootstrap.step import Step, StepFailed
from commands.paths import (
    BUILD,
    DEVEL,
    GAZEBO_STAMP,
    ROOT,
    SOURCES,
    SYSTEM_PATH,
    VENV,
    VENV_PYTHON,
    read,
    relative,
    write,
)

STANDINS = os.path.join(SOURCES, "standins")
NAMES = ("CMakeLists.txt", "package.xml", "setup.py", "CATKIN_IGNORE")
SUFFIXES = (
    *(".msg", ".srv", ".action", ".cfg", ".cmake", ".in"),
    *(".c", ".cc", ".cpp", ".cxx", ".h", ".hh", ".hpp"),
)
RULE = os.path.join(STANDINS, "give_way.py")  # which stand-ins give way, and to what
# The folders of src/ that are Paddock's; all others are what a user has put there.
OURS = (
    "bullet_bridge",
    "bullet_gazebo_host",
    "bullet_sim",
    "bullet_web",
    "cybertruck",
    "deepracer_control",
    "deepracer_teleop",
    "paddock_common",
    "paddock_gym",
    "paddock_navigation",
    "standins",
    "track_model",
)
GAZEBO_CMAKE = os.path.join(STANDINS, "gazebo_dev", "cmake")
MARKER = "CATKIN_IGNORE"
SIMULATOR = ("gazebo_ros",)  # its launch files start the simulator: always ours
ALWAYS_FOUND = ("xacro",)  # though not built: $(find xacro)/xacro.py of old launch files
LISTED = ("nodes", "scripts")  # folders whose files are linked or wrapped by the build
GENERATED = os.path.join(SOURCES, "CMakeLists.txt")  # by catkin_make
STAMP = os.path.join(BUILD, ".stamp")  # the key of a complete build
BUILT_AT = os.path.join(BUILD, ".root")
BUILT = os.path.join(BUILD, ".packages")
GIVEN = os.path.join(BUILD, ".given")  # stand-ins that had given way
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
# Run by .venv's Python with the path of bullet_sim's sources. Of its packages only what is compiled
# is imported: the rest needs PyBullet, which may not be there yet.
COMPILE = """
import sys, types
sys.modules["bullet_sim.engine"] = types.ModuleType("bullet_sim.engine")
sys.modules["bullet_sim.engine"].__path__ = [f"{sys.argv[1]}/bullet_sim/engine"]
from bullet_sim.engine.quickstep import sources
if not sources.library_path().is_file():  # sources with new dates may be the same
    from bullet_sim.engine.quickstep import entries
    entries.main()
"""
# Files for find_package(catkin), which include Debian's.
CATKIN = {
    "catkinConfig.cmake": """set(catkin_DIR /usr/share/catkin/cmake)
if(CATKIN_TOPLEVEL AND NOT COMMAND catkin_workspace)
  set(CATKIN_TOPLEVEL_FIND_PACKAGE TRUE)
  include(${catkin_DIR}/catkinConfig.cmake NO_POLICY_SCOPE)
  unset(CATKIN_TOPLEVEL_FIND_PACKAGE)
else()
  include(${catkin_DIR}/catkinConfig.cmake NO_POLICY_SCOPE)
endif()
""",
    "catkinConfig-version.cmake": "include(/usr/share/catkin/cmake/catkinConfig-version.cmake)\n",
}
# What stand-ins make in devel/ under other names than their own.
MAKES = {"gazebo_dev": ("gazebo",), "state_publisher": ("robot_state_publisher",)}
_loaded = {}
COMPILERS = ("CC", "CXX", "CFLAGS", "CXXFLAGS", "LDFLAGS")


def rule():
    """Loads src/standins/give_way.py, which users run in workspaces of their own, too."""
    if "rule" not in _loaded:
        import importlib.util

        spec = importlib.util.spec_from_file_location("give_way", RULE)
        _loaded["rule"] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(_loaded["rule"])
    return _loaded["rule"]


def installed_elsewhere():
    """Lists stand-ins whose real package the ROS has."""
    names = sorted(os.listdir(STANDINS)) if os.path.isdir(STANDINS) else []
    return [name for name in names if name not in SIMULATOR and in_ros(name)]


def users_packages():
    """Finds the packages that a user has put into src/: of each name its folder."""
    below = manifests_of(SOURCES, skipped=STANDINS)
    return {name: path for name, path in below.items() if top(path) not in OURS}


def top(path):
    """Returns the folder in src/ that a path is in."""
    return os.path.relpath(path, SOURCES).split(os.sep)[0]


def _manifests_of_users():
    """Lists the package.xml files of a user, those that catkin refuses among them."""
    below = rule().manifests_below(SOURCES, STANDINS)
    return [path for path in below if top(path) not in OURS]


def _refuse(environ):
    """Hides the packages of a user whose package.xml catkin refuses; returns them as LeftOut."""
    theirs = [os.path.dirname(path) for path in _manifests_of_users()]
    refused = left_out.refused(theirs, environ)
    rule().mark_refused(theirs, refused)
    return [
        left_out.LeftOut(
            rule().name_of(f"{path}/package.xml") or relative(path),
            "",
            f"catkin refuses {relative(path)}/package.xml: {why[:300]}",
        )
        for path, why in refused.items()
    ]


def copies():
    """Finds the packages of a user that are in several places of src/: of each name the folders."""
    result = {}
    for path in _manifests_of_users():
        result.setdefault(rule().name_of(path), []).append(os.path.dirname(path))
    return {name: folders for name, folders in result.items() if name and len(folders) > 1}


def given_way(users=None):
    """Lists the stand-ins whose real package the ROS has, or the user's sources; they are left out
    of the build.

    Args:
        users: See users_packages(); None to look.
    """
    if not os.path.isdir(STANDINS):
        return []
    users = users_packages() if users is None else users
    real = (set(users) - set(rule().NEED_GAZEBO)) & set(os.listdir(STANDINS))
    return sorted({*installed_elsewhere(), *real})


def hide(users=None):
    """Hides the stand-ins that are left out from rospack and $(find), which search the sources.

    Args:
        users: See users_packages(); None to look.

    Returns:
        Names of the user's packages that are hidden, as they need Gazebo itself.
    """
    if not os.path.isdir(STANDINS):
        return []
    users = users_packages() if users is None else users
    seen = [name for name in ALWAYS_FOUND if name not in users]
    rule().give_way(STANDINS, set(given_way(users)), seen)
    return rule().keep_ours(users)


def manifests_below(folder):
    """Lists the package.xml files at and below a folder, as catkin finds them."""
    return rule().manifests_below(folder)


def manifests_of(folder, skipped=None):
    """Finds the packages at and below a folder: of each name its folder."""
    return rule().packages_below(folder, skipped)


def package_folder(name):
    """Returns the folder of a package of src/ or of ROS_PACKAGE_PATH; None: there is none."""
    for place in [SOURCES, *filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(":"))]:
        folder = manifests_of(place).get(name)
        if folder:
            return folder
    return None


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
        subdirectories[:] = sorted(
            name for name in subdirectories if name != "__pycache__" and not name.startswith(".")
        )
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
    return _key(_hash(inputs, names))


def _key(sources):
    import hashlib

    return hashlib.sha256("\n".join([*_base(), sources]).encode()).hexdigest()


def _hash(inputs, names):
    import hashlib

    whole = hashlib.sha256("\n".join(names).encode())
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
    """Lists what else a build is bound to: the place of the clone, the ROS, what that has; and if
    something was left out, what is installed at all, and how old code is helped."""
    base = [ROOT, *filter(None, [ros.prefix()]), *installed_elsewhere(), read(GAZEBO_STAMP)]
    if left_out.saved():  # it may be there now, or be built now
        changing = [packages.INSTALLED, *old_code.helpers()]
        changed = [os.stat(path).st_mtime_ns for path in changing if os.path.exists(path)]
        base.append(f"installed at and helped since {changed}")
    return base


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
    result = []
    if changing or not _is_unchanged():
        advice = "The lines above name the package. To build from scratch: rm -rf build devel"
        result.append(Step(3, "Workspace", _build_workspace, advice, "build_workspace"))
    if changing or not _is_compiled():
        result.append(Step(4, "Solver", _compile, "The lines above say why.", "compile_solver"))
    return result


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
    sources = glob.glob(f"{SOLVER}/*.py")
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


def _build(step):
    folder = ros.prefix()
    environ = _environment(folder)
    broken = _refuse(environ)
    users = users_packages()
    hidden = hide(users)
    for name in hidden:
        step.note(f"not built: {relative(users[name])}: it needs Gazebo itself, ours is used")
    _, inputs, names = scan()
    folders = list_packages(inputs)
    sources = _hash(inputs, names)  # before: what changes meanwhile is built the next time
    gone = set(read(BUILT).split("\n")[:-1]) - set(folders)
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
    given = given_way(users)
    for name in set(given) - set(read(GIVEN).split("\n")):
        _forget(name)
    write(GIVEN, "".join(f"{name}\n" for name in given))
    for stamp in (STAMP, left_out.FILE):
        if os.path.exists(stamp):
            os.remove(stamp)
    write(BUILT, "".join(f"{name}\n" for name in folders))
    users = {name: path for name, path in users.items() if name not in hidden}
    foreign = plain_cmake.foreign(users)
    ours = {name: path for name, path in users.items() if name not in foreign}
    for line in old_code.prepare(ours, manifests_of(SOURCES)):
        step.note(line)
    others = yield from plain_cmake.build(step, environ, users)
    refused = yield from _configure(step, environ, ours, foreign)
    failed = yield from _make(step, environ, ours)
    entries = [*broken, *others, *refused, *failed]
    left_out.save(entries)
    for line in left_out.lines(entries):
        step.note(line)
    offer_catkin()
    write(STAMP, f"{_key(sources)}\n")


def offer_catkin():
    """Lets src/CMakeLists.txt of workspaces that is committed as a file find Debian's catkin.

    ROS's looks in the workspaces of CMAKE_PREFIX_PATH alone, and /usr is none.
    """
    if ros.prefix():
        return
    for name, text in CATKIN.items():
        write(os.path.join(DEVEL, "share", "catkin", "cmake", name), text)


def _forget(name):
    """Deletes what was built of a stand-in that gives way now: it would be found beside the real
    package."""
    import shutil

    places = ("lib", "share", "include", "lib/python3*/dist-packages")
    for made in (name, *MAKES.get(name, ())):
        for path in [path for place in places for path in glob.glob(f"{DEVEL}/{place}/{made}")]:
            shutil.rmtree(path)
    shutil.rmtree(os.path.join(BUILD, "standins", name), ignore_errors=True)


def _environment(folder):
    left_out_names = (*LEFT_OUT, *(() if os.path.isdir(f"{folder}/conda-meta") else COMPILERS))
    environ = {name: value for name, value in os.environ.items() if name not in left_out_names}
    environ["PATH"] = SYSTEM_PATH
    ros.enter(environ, folder)
    environ.pop("ROS_DISTRO", None)  # catkin fails where it is another one than the ROS sets
    environ.update(PATH=f"{VENV}/bin:{environ['PATH']}", PYTHONNOUSERSITE="1", VIRTUAL_ENV=VENV)
    environ["LC_ALL"] = "C.UTF-8"  # messages in English, which left_out.py reads
    configured = [f"{DEVEL}/lib/pkgconfig", environ.get("PKG_CONFIG_PATH", "")]  # as setup.sh does
    environ["PKG_CONFIG_PATH"] = ":".join(filter(None, configured))
    return environ


def _configure(step, environ, users, foreign):
    """Configures the workspace, without the users' packages that cannot be.

    Args:
        foreign: Names of packages that are not catkin's.

    Returns:
        List of LeftOut.
    """
    ours = set(manifests_of(SOURCES))
    refused = left_out.before_configuration(users, lambda name: in_ros(name) or name in ours)
    while True:
        begin = os.path.getsize(step.log) if step.begun is not None else 0
        # By names: a user's package of a stand-in's name is not among them, the stand-in is hidden.
        given = set(installed_elsewhere()) - set(users)
        without = sorted({*given, *foreign, *(entry.package for entry in refused)})
        prefixes = environ.get("CMAKE_PREFIX_PATH", "").replace(":", ";")
        try:
            yield (
                [
                    "catkin_make",
                    "-C",
                    ROOT,
                    f"-DPYTHON_EXECUTABLE={VENV_PYTHON}",
                    f"-DCMAKE_PREFIX_PATH={prefixes}",
                    "-DCMAKE_BUILD_TYPE=Release",
                    "-DCATKIN_ENABLE_TESTING=OFF",
                    "-DCATKIN_BLACKLIST_PACKAGES=" + ";".join(without),
                    *old_code.options(),
                    *_gazebo(),
                    "cmake_check_build_system",
                ],
                environ,
            )
            return refused
        except StepFailed:
            result = left_out.of_configuration(_log(step, begin))
            if not result or any(entry.package not in users for entry in result):
                raise
            refused += result


def _gazebo():
    """Returns the arguments of cmake by which find_package(gazebo) finds our stand-in.

    The last one changes with Gazebo's libraries, so that the workspace is configured with them.
    """
    if glob.glob("/usr/lib/*/cmake/gazebo") or not os.path.isdir(GAZEBO_CMAKE):
        return []
    found = [f"-D{name}_DIR={GAZEBO_CMAKE}" for name in ("gazebo", "GAZEBO", "Gazebo")]
    libraries = ",".join(read(GAZEBO_STAMP).split()) or "none"
    return [*found, f"-DPADDOCK_GAZEBO_LIBRARIES={libraries}"]


def _make(step, environ, users):
    """Builds all that can be: messages first, as some packages forget that they need their own.

    Returns:
        List of LeftOut.
    """
    make = ["make", "-C", BUILD, "-k", "-O", plain_cmake.jobs()]
    begin = os.path.getsize(step.log)
    result = {}
    for targets in (_message_targets(users), ["all"]):
        try:
            if targets:
                yield [*make, *targets], environ
        except StepFailed:
            ours = {os.path.relpath(path, SOURCES): name for name, path in users.items()}
            failed = left_out.of_build(_log(step, begin), ours)
            if not failed or not all(entry.package for entry in failed):
                raise
            result.update({(entry.package, entry.program): entry for entry in failed})
    return list(result.values())


def _message_targets(users):
    """Lists the users' targets that make messages and parameters of dynamic_reconfigure."""
    import re

    rules = read(os.path.join(BUILD, "Makefile"))
    result = re.findall(r"^((\w+)_(?:generate_messages|gencfg)):", rules, re.M)
    return sorted({target for target, name in result if name in users})


def _log(step, begin):
    with open(step.log, encoding="utf-8", errors="replace") as stream:
        stream.seek(begin)
        return stream.read()
