"""Step 2, Python packages in .venv: those that all need, and those of some commands."""

import glob
import os
import sys

from commands import signature
from commands.bootstrap import packages, ros
from commands.bootstrap.step import SetupLock, Step, run_beside
from commands.errors import CommandError
from commands.paths import CACHE, OWN, ROOT, VENV, VENV_PYTHON, VENV_STAMP, read, write

REQUIREMENTS = os.path.join(ROOT, "config", "requirements.txt")
OPENCV = os.path.join(ROOT, "config", "requirements-opencv.txt")
HEADLESS = os.path.join(VENV, "opencv")  # where it is: config/python/sitecustomize.py finds it
# Run by .venv's Python, with the path of .venv: whether what Paddock imports is there.
CHECK = """
import sys
sys.path.append(sys.argv[1] + "/opencv")
import av, cv2, cv_bridge, numpy, pybullet, rospy, xacro, yaml
from PyQt5 import QtWidgets
if numpy.__file__.startswith(sys.argv[1]) and sys.version_info >= (3, 10):
    sys.exit(f"numpy is {numpy.__version__} of .venv; Debian's has to stay, cv_bridge needs it")
"""
ADVICE = "Check the network (or your pip index settings) and that the disk is not full."
WHEELS = os.path.join(CACHE, "wheels")  # what was compiled here
# The last Python, and the one machine, for which PyPI has a wheel of it.
COMPILED, WHEELS_UP_TO, WHEELS_FOR = "pybullet", (3, 11), "x86_64"
MACHINE = os.uname().machine
# Of the solver, with what it imports: installed first, as that takes a minute to compile. The last
# three have pins where the system's numpy is too old for numba, or Python has too little.
COMPILER = ("numba", "llvmlite", "numpy", "importlib_metadata", "zipp")
# Half of what is in these are symbols for debuggers: 150 MB.
WITH_SYMBOLS = ("pybullet.*.so", "eglRenderer.*.so", "llvmlite/binding/libllvmlite.so")

# gcc 14 makes an error of a cast that numpy 2 wants: PyArray_DATA() of a PyObject
CFLAGS = "-g0 -w -Wno-error=incompatible-pointer-types"
# Name of the lists in config/ (requirements-NAME.txt, and apt-NAME.txt where it needs Debian's
# packages, too) -> what must be importable.
EXTRAS = {
    "gym": "gymnasium, onnx, onnxruntime",
    "learning": "stable_baselines3, torch",
    "ray": "ray",
    "sweep": "optuna",
    "tensorboard": "tensorboard",
    "test": "hypothesis, pytest, vehiclemodels",
    "lint": "mypy, ruff, vermin",
}
BELOW = {"learning": ("gym",), "sweep": ("gym",)}  # what else a list needs


def steps():
    """Gives the steps that make or complete .venv if its inputs changed."""
    if signature.unchanged("venv", _key()):
        return []
    result = [Step(2, "Python packages", _prepare, ADVICE, "install_python", ("venv", "numba"))]
    if not _complete():
        advice = "The lines above say what the compiler misses."
        result.append(Step(2, "PyBullet", _compile, advice, "compile_pybullet", ("wheel",)))
    return result


def ready():
    """Returns whether there is nothing to do."""
    return signature.unchanged("venv", _key()) or _complete()


def _key():
    return f"{ROOT} {ros.prefix()}"


def _complete():
    return os.access(VENV_PYTHON, os.X_OK) and read(VENV_STAMP) == _stamp()


def _base():
    """Names what .venv is bound to: a Python, the clone's place, the folder of a sourced ROS."""
    return f"{os.path.realpath(ros.python())} {ROOT} {ros.prefix()}".rstrip()


def _stamp():
    """What STAMP holds when .venv is complete."""
    import hashlib

    lists = read(REQUIREMENTS) + read(OPENCV)
    return f"{_base()}\n{hashlib.sha256(lists.encode()).hexdigest()}\n"


def _prepare(step):
    if not _complete():
        yield from _install(step)
    signature.save("venv", _key(), [REQUIREMENTS, OPENCV, VENV_STAMP, VENV_PYTHON, ros.python()])


def _install(step):
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    folder = ros.prefix()
    ros.leave(environ, folder)
    if read(VENV_STAMP).split("\n")[0] != _base():
        import shutil

        if os.path.isdir(VENV):
            shutil.rmtree(VENV)
        yield [ros.python(), "-m", "venv", "--system-site-packages", VENV], environ
    _begin(folder)
    step.reach("venv")
    first = [pin for pin in _pins() if _name(pin) in COMPILER]
    compiled = [pin for pin in _pins() if _name(pin) == COMPILED and not _has_wheel()]
    rest = [pin for pin in _pins() if pin not in (*first, *compiled)]
    if first:
        yield [*_pip("install"), *first], environ
    step.reach("numba")
    yield [*_pip("install"), *rest], environ
    if compiled:
        yield "wheel"
        yield [*_pip("install"), "--find-links", WHEELS, *compiled], environ
    if glob.glob(f"{VENV}/lib/python3*/site-packages/opencv_python_headless-*"):  # of an older list
        yield [VENV_PYTHON, "-m", "pip", "uninstall", "-y", "opencv-python-headless"], environ
    yield [*_pip("install"), "--target", HEADLESS, "--upgrade", "-r", OPENCV], environ
    yield from _strip(environ)
    ros.enter(environ, folder)
    yield "packages"
    yield [VENV_PYTHON, "-c", CHECK, VENV], environ
    write(VENV_STAMP, _stamp())


def _pins():
    """Lists the lines of config/requirements.txt as pip takes them: NAME==VERSION; MARKER."""
    lines = (line.partition("#")[0].strip() for line in read(REQUIREMENTS).splitlines())
    return [line for line in lines if line]


def _name(pin):
    return pin.partition("==")[0]


def _strip(environ):
    """Leaves out symbols for debuggers, into new files: those that were there may be in use."""
    import shutil

    if not shutil.which("strip"):
        return
    folder = glob.glob(f"{VENV}/lib/python3*/site-packages")
    for path in [path for part in WITH_SYMBOLS for path in glob.glob(f"{folder[0]}/{part}")]:
        yield ["strip", "--strip-unneeded", "-o", f"{path}.stripped", path], environ
        os.replace(f"{path}.stripped", path)


def _begin(folder):
    """Marks .venv as incomplete: what pip leaves half done cannot be known, it is made again then.

    Args:
        folder: Of a sourced ROS, which is remembered nevertheless; or empty.
    """
    if folder:
        write(VENV_STAMP, f"? {ROOT} {folder}\n")
    elif os.path.exists(VENV_STAMP):
        os.remove(VENV_STAMP)


def _pip(command):
    words = [VENV_PYTHON, "-m", "pip", command, "--disable-pip-version-check", "--no-deps"]
    return [*words, "--no-compile"] if command == "install" else words


def _compile(step):
    """Compiles what PyPI has no wheel of for this Python, unless an earlier set-up has."""
    yield "venv"
    pin = next((pin for pin in _pins() if _name(pin) == COMPILED), None)
    if pin is None or _has_wheel() or _compiled(pin):
        return
    where = "Python {}.{}".format(*_version()) + ("" if MACHINE == WHEELS_FOR else f" on {MACHINE}")
    step.note(f"PyPI has no {COMPILED} for {where}: compiling it, once; 8 minutes on two cores")
    environ = dict(os.environ, PYTHONNOUSERSITE="1", CFLAGS=CFLAGS)
    ros.leave(environ, ros.prefix())
    # Without isolation it finds numpy, for images as arrays; a wheel in pip's cache may lack it.
    options = ("--no-build-isolation", "--no-cache-dir", "-w", WHEELS)
    yield [*_pip("wheel"), *options, pin], environ


def _has_wheel():
    return MACHINE == WHEELS_FOR and _version() <= WHEELS_UP_TO


def _version():
    """Returns the version of .venv's Python: (3, 11). It need not be the one that runs this."""
    for line in read(os.path.join(VENV, "pyvenv.cfg")).splitlines():
        if line.startswith("version ="):
            major, minor = line.partition("=")[2].split(".")[:2]
            return int(major), int(minor)
    return sys.version_info[:2]


def _compiled(pin):
    """Returns whether an earlier set-up has left the wheel of a pin for this Python."""
    name, _, version = pin.partition("==")
    tag = "cp{}{}".format(*_version())
    return bool(glob.glob(os.path.join(WHEELS, f"{name}-{version}-{tag}-*.whl")))


def prepare_extras(*names):
    """Installs what is missing, after bootstrap.prepare().

    Args:
        names: Of EXTRAS; none: learning.

    Raises:
        CommandError: A step failed, or the clone is another user's.
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    wanted = [extra for name in names or ("learning",) for extra in (*BELOW.get(name, ()), name)]
    with SetupLock():
        for name in dict.fromkeys(wanted):
            packages.prepare_more(f"apt-{name}.txt", steps=2)
        missing = [name for name in dict.fromkeys(wanted) if not _has_extra(name)]
        if missing and not OWN:
            command = f"./run setup --with {','.join(missing)}"
            raise CommandError(f"{ROOT} belongs to another user, who has to type there: {command}")
        if missing:
            title, log = f"Python packages ({', '.join(missing)})", f"install_{'_'.join(missing)}"
            run_beside([Step(2, title, lambda _: _install_extras(missing), ADVICE, log, of=2)])


def extra_requirements(name):
    """Returns the path of a list of Python packages."""
    return os.path.join(ROOT, "config", f"requirements-{name}.txt")


def _has_extra(name):
    return read(_extra_stamp(name)) == _extra_wanted(name)


def _extra_stamp(name):
    return os.path.join(VENV, f".stamp-{name}")


def _extra_wanted(name):
    """What the stamp holds when everything is there."""
    return read(os.path.join(VENV, ".stamp")).split("\n")[0] + "\n" + read(extra_requirements(name))


def _install_extras(names):
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    lists = [word for name in names for word in ("-r", extra_requirements(name))]
    yield [*_pip("install"), *lists], environ
    for name in names:
        yield [VENV_PYTHON, "-c", f"import {EXTRAS[name]}"], environ
        write(_extra_stamp(name), _extra_wanted(name))
