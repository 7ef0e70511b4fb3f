"""At the start of each Python in Paddock's environment: which cv2 it imports, what if no screen.

QtPy, which rqt_plot draws with, does not know the bindings by the names that ROS gives them.

Programs of users get the system's cv2, which has windows. Paddock's own get that of .venv/opencv,
which has none and is imported in a quarter of the time, with 80 MB less; so does whoever has no
other. Users' Qt windows get paddock_qt. Nothing is imported here before a program asks for it.
"""

import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
HEADLESS = os.path.join(ROOT, ".venv", "opencv")
# The folders of src/ that are Paddock's, as commands.bootstrap.workspace.OURS.
OURS = (
    *("bullet_bridge", "bullet_gazebo_host", "bullet_sim", "bullet_web", "cybertruck"),
    *("deepracer_control", "deepracer_teleop", "paddock_common", "paddock_gym"),
    *("paddock_navigation", "standins", "track_model"),
)
# Module -> variable that lets its library run without a screen, and its value.
WITHOUT_SCREEN = {
    "PyQt5": ("QT_QPA_PLATFORM", "offscreen"),
    "PySide2": ("QT_QPA_PLATFORM", "offscreen"),
    "pygame": ("SDL_VIDEODRIVER", "dummy"),
}
QT = ("PyQt5.QtCore", "PyQt5.QtGui", "PyQt5.QtWidgets")  # what paddock_qt changes
QT_API = {"pyqt": "pyqt5", "pyside": "pyside2"}  # of python_qt_binding -> of QtPy


def has_screen():
    """Whether there is a display for windows."""
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def is_own():
    """Whether the program of this process is one of Paddock's, or a worker of Ray for trainings."""
    program = (getattr(sys, "argv", None) or [""])[0]
    if program in ("", "-c"):
        return False
    if program == "-m":  # its package is being imported: sys.argv has no path yet
        with open("/proc/self/cmdline", "rb") as stream:
            words = [os.fsdecode(word) for word in stream.read().split(b"\0")]
        return words[words.index("-m") + 1].split(".")[0] in (*OURS, "commands")
    path = os.path.relpath(os.path.realpath(program), ROOT).split(os.sep)
    if path[-2:-1] == ["workers"] and "ray" in path:
        return True
    if path[0] == "src":
        return path[1] in OURS
    if path[0] in ("devel", "install"):  # lib/PACKAGE/PROGRAM
        package = path[max(-2, -len(path))]
        return package in OURS or os.path.isdir(os.path.join(ROOT, "src", "standins", package))
    return path[0] in ("bench", "commands", "docs", "tests")


class Finder:
    """Finds modules of WITHOUT_SCREEN and QT, qtpy and cv2, by asking the others; each once."""

    wanted = {"cv2", "qtpy", *WITHOUT_SCREEN, *(QT if sys.version_info >= (3, 10) else ())}

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        """As every finder of sys.meta_path; None: it is for the others."""
        if name not in cls.wanted:
            return None
        cls.wanted.discard(name)
        if name == "qtpy":
            if os.environ.get("QT_API") in QT_API:
                os.environ["QT_API"] = QT_API[os.environ["QT_API"]]
            return None
        if name in QT:
            return None if is_own() else found_with(name, "paddock_qt")
        if name != "cv2":
            if not has_screen() and not is_own():
                os.environ.setdefault(*WITHOUT_SCREEN[name])
            return None
        if HEADLESS in sys.path:  # asked for
            return None
        if is_own():
            sys.path.insert(0, HEADLESS)
            return None
        sys.path.append(HEADLESS)
        return found_with("cv2", "paddock_windows", has_screen())


def found_with(name, changer, *arguments):
    """Finds a module, which install() of another changes once it is executed; None: not found."""
    from importlib.util import find_spec

    spec = find_spec(name)
    if spec is not None:
        execute = spec.loader.exec_module

        def exec_module(module):
            execute(module)
            __import__(changer).install(sys.modules[name], *arguments)

        spec.loader.exec_module = exec_module
    return spec


def call_next():
    """Runs the sitecustomize that would have been found without this one, of Debian for example."""
    from importlib.machinery import PathFinder

    here = os.path.dirname(os.path.realpath(__file__))
    others = [path for path in sys.path if os.path.realpath(path) != here]
    spec = PathFinder.find_spec("sitecustomize", others)
    if spec is not None:
        spec.loader.exec_module(type(sys)("sitecustomize"))


sys.meta_path.insert(0, Finder)
call_next()
