"""Holds the direction of imports: robot packages <- nothing of the simulator, core <- no ROS."""

import ast
import functools
import importlib.util
from pathlib import Path

import pytest
from test_import_circles import imported_names

from commands.bootstrap import workspace

ROOT = Path(__file__).resolve().parents[2]
ROBOT_PACKAGES = sorted(
    path.parent.name
    for path in (ROOT / "src").glob("*/package.xml")
    if path.parent.name
    not in (
        "bullet_sim",
        "bullet_bridge",
        "bullet_web",
        "paddock_gym",
        "paddock_navigation",
    )  # maps are of simulated worlds
)
SIMULATOR = {"bullet_sim", "bullet_bridge", "pybullet", "pybullet_data"}
ROS_CLIENTS = (
    "rospy roslib roslaunch rosgraph rospkg rosparam genpy actionlib cv_bridge tf tf2_ros "
    "message_filters dynamic_reconfigure std_srvs"
).split()


@functools.lru_cache(maxsize=None)
def python_files(directory):
    """Lists a directory's Python files: *.py, and scripts whose first line names python.

    Raises:
        FileNotFoundError: there is no such directory, so that a check of it would check nothing.
    """
    if not directory.is_dir():
        raise FileNotFoundError(directory)
    return [
        path
        for path in sorted(directory.rglob("*"))
        if "__pycache__" not in path.parts
        and path.is_file()
        and (path.suffix == ".py" or (path.suffix == "" and is_python_script(path)))
    ]


def is_python_script(path):
    """Returns whether a file's first line names Python."""
    with path.open("rb") as stream:
        first = stream.readline()
    return first.startswith(b"#!") and b"python" in first


@functools.lru_cache(maxsize=None)
def imports_in(path, package=""):
    """Lists what a file imports, as imported_names()."""
    return imported_names(path.read_text(), package)


def imports_of(path):
    """Returns the (top-level name, line) of what a file imports from outside of its package."""
    return {(name.split(".")[0], line) for name, line in imports_in(path) if name[0] != "."}


def offences(directory, forbidden, exempt=()):
    """Lists "file:line imports name" for every forbidden import below a directory."""
    return [
        f"{path.relative_to(ROOT)}:{line} imports {name}"
        for path in python_files(directory)
        if path not in exempt
        for name, line in sorted(imports_of(path))
        if forbidden(name)
    ]


def is_ros(name):
    """Returns whether a module is a ROS client library or a message package."""
    return name in ROS_CLIENTS or name.endswith("_msgs")


@pytest.mark.parametrize("package", ROBOT_PACKAGES)
def test_robot_packages_do_not_know_the_simulator(package):
    assert offences(ROOT / "src" / package, SIMULATOR.__contains__) == []


GYM = ROOT / "src" / "paddock_gym" / "src" / "paddock_gym"


def all_but(*packages):
    """The folders of src/ without those of packages."""
    return [path for path in sorted((ROOT / "src").iterdir())
            if path.is_dir() and path.name not in packages]  # fmt: skip


def gym(*names):
    """Files and folders of the gym, as files."""
    return {path for name in names
            for path in ([GYM / name] if "." in name else python_files(GYM / name))}  # fmt: skip


# what may not import what: folders, what is forbidden, files that may all the same
RULES = {
    "the core, ROS": ([ROOT / "src" / "bullet_sim"], is_ros, ()),
    "the gym, ROS but in its driver and for a launch file": (
        [GYM],
        is_ros,
        gym("driver", "simulation/launch_file.py"),
    ),
    "what a robot needs of the gym, the simulator": (
        [GYM],
        {*SIMULATOR, "gymnasium"}.__contains__,
        # __init__.py registers the environments where Gymnasium is installed
        gym("__init__.py", "simulation", "envs", "evaluation", "training", "sweep"),
    ),
    "all others, the gym": (
        all_but("paddock_gym", "paddock_navigation"),  # maps are of its worlds
        {"paddock_gym"}.__contains__,
        (),
    ),
    "all but training, torch": (
        [GYM],
        {"torch", "stable_baselines3", "pandas"}.__contains__,
        gym("training", "policy/export.py"),
    ),
    "the simulator, Qt": (
        [ROOT / "src" / name for name in ("bullet_sim", "bullet_bridge", "bullet_web")],
        {"PyQt5"}.__contains__,
        (),
    ),
    "all others, the bridge": (all_but("bullet_bridge"), {"bullet_bridge"}.__contains__, ()),
}


@pytest.mark.parametrize("rule", RULES)
def test_who_imports_whom(rule):
    folders, forbidden, exempt = RULES[rule]
    assert [line for folder in folders for line in offences(folder, forbidden, exempt)] == []


def test_only_the_engine_imports_pybullet():
    engine = ROOT / "src" / "bullet_sim" / "src" / "bullet_sim" / "engine"
    names = {"pybullet", "pybullet_data"}
    bullet = [*python_files(engine / "bullet"), *python_files(engine.parents[2] / "test")]
    assert any(name == "pybullet" for path in bullet for name, _ in imports_of(path))
    assert offences(ROOT / "src", names.__contains__, exempt=bullet) == []


def test_only_the_engine_sees_its_modules():
    base = ROOT / "src" / "bullet_sim" / "src" / "bullet_sim"
    public = ("engine.api.", "engine.efforts.", "engine.quickstep.law", "engine.quickstep.layout",
              "engine.bullet.camera.",
              "engine.bullet.client.Client", "engine.bullet.urdf.visual_urdf")  # fmt: skip
    wrong = [
        f"{path.relative_to(ROOT)}:{line} imports bullet_sim.{name}"
        for path in python_files(ROOT / "src")
        if base / "engine" not in path.parents and base.parents[1] / "test" not in path.parents
        for name, line in sorted(inner_imports("bullet_sim", path, base))
        if name.count(".") > 1 and name.startswith("engine.") and not name.startswith(public)
    ]
    assert wrong == []


# Sub-packages of each package, lowest first: one imports only those that stand before it, and the
# modules of its package's top that stand before it, too. "" are all modules of the top not named.
SUITES = {
    "paddock_common": ("process", ""),
    "bullet_sim": (
        "errors pose component registry files child description snapshot kinematics xml_reader "
        "meshes engine controllers models sensors render parts plugins formats world robots"
    ).split(),
    "bullet_bridge": (
        "srv",
        "transport",
        "loop",
        "resolve",
        "gazebo_host",
        "plugins",
        "control",
        "robots",
        "services",
        "",
    ),
    "bullet_web": (
        "messages driving scene server files replay window sensors navigation graph simulator "
        "actions record bag node"
    ).split(),
    "track_model": (
        "msg",
        "spec",
        "track_file",
        "routes",
        "source",
        "curves",
        "geometry",
        "region",
        "files",
        "track",
        "referee",
        "",
    ),
    "cybertruck": ("msg", "srv", "drive", "trailer", "goal", "teleop", "plot", "backing"),
    "deepracer_teleop": ("camera", "input_devices", "recording", "window", "drivers", "runs"),
    "paddock_gym": (
        "errors ids course contract observations policy driver simulation envs evaluation "
        "training sweep"
    ).split(),
}


def inner_imports(package, path, base):
    """Gives the modules of a package that a file in it or elsewhere imports.

    Returns:
        Set of (dotted name, line).
    """
    own = path.relative_to(base).parent.parts if base in path.parents else ()
    within = ".".join([package, *own]) if base in path.parents else ""
    start = f"{package}."
    return {
        (name[len(start) :], line)
        for name, line in imports_in(path, within)
        if name.startswith(start)
    }


@pytest.mark.parametrize("package", SUITES)
def test_sub_packages_import_one_way(package):
    base, order = ROOT / "src" / package / "src" / package, SUITES[package]
    wrong, seen = [], set()

    def rank(suite):
        return order.index(suite if suite in order else "")

    for path in sorted(base.rglob("*.py")):
        parts = path.relative_to(base).with_suffix("").parts
        if parts == ("__init__",):
            continue
        seen.add(parts[0])
        for name, line in sorted(inner_imports(package, path, base)):
            suite = name.split(".")[0]
            if suite != parts[0] and suite != "__init__" and rank(suite) > rank(parts[0]):
                wrong.append(f"{path.relative_to(ROOT)}:{line} imports {package}.{name}")
    assert wrong == []
    assert set(order) - seen <= {"", "msg", "srv"}, "the table names what is not there"


@pytest.mark.parametrize("package", SUITES)
def test_sub_packages_say_what_they_are(package):
    base = ROOT / "src" / package / "src" / package
    silent = [
        str(path.relative_to(ROOT))
        for path in base.rglob("__init__.py")
        if not ast.get_docstring(ast.parse(path.read_text()))
    ]
    assert silent == []


def test_the_picture_of_the_packages_has_all_of_them():
    source = ast.parse((ROOT / "docs" / "tools" / "rooms.py").read_text())
    places = next(
        ast.literal_eval(node.value)
        for node in source.body
        if isinstance(node, ast.Assign) and node.targets[0].id == "PLACES"
    )
    assert set(places) == {path.parent.name for path in (ROOT / "src").glob("*/package.xml")} & set(
        workspace.OURS  # without what a user has put there
    )


OTHER_PYTHONS = (  # with site-packages: Debian's, or the one of .venv
    "check_observer check_roslaunch check_sources desk_web manifest_condition noetic_index "
    "rosdep_lookup roslaunch"
).split()


def test_run_imports_the_standard_library_only():
    """./run is python3 -I -S: Debian's packages are not on its path, though tests see them."""
    for path in python_files(ROOT / "commands"):
        for name, line in imports_of(path) if path.stem not in OTHER_PYTHONS else ():
            spec = importlib.util.find_spec(name)
            assert spec and "-packages" not in (spec.origin or ""), (path, line, name)
