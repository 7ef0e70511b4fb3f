"""config/python: which cv2 a program imports, its windows without a screen, other libraries."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from commands.bootstrap import workspace
from commands.paths import ROOT, VENV_PYTHON

START = Path(ROOT, "config", "python")
HEADLESS = Path(ROOT, ".venv", "opencv")
sys.path.append(str(START))

import paddock_windows  # noqa: E402

WHICH = "import cv2; print(cv2.__file__)"


def start(*words, python=VENV_PYTHON, **variables):
    """What a Python prints, without a screen."""
    drop = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "SDL_VIDEODRIVER")
    environ = {name: value for name, value in os.environ.items() if name not in drop}
    environ["PYTHONPATH"] = f"{START}:{environ.get('PYTHONPATH', '')}"
    done = subprocess.run([python, *words], env={**environ, **variables}, capture_output=True,
                          text=True, check=True, timeout=120)  # fmt: skip
    return done.stdout.strip()


def test_the_folders_of_paddock_are_those_of_the_build():
    code = "import sitecustomize; print(' '.join(sitecustomize.OURS))"
    assert tuple(start("-c", code).split()) == workspace.OURS


@pytest.mark.parametrize(
    "path, is_own",
    [
        ("src/bullet_web/nodes/web", True),
        ("src/standins/joy/scripts/joy_node", True),
        ("devel/lib/bullet_web/web", True),
        ("devel/lib/joy/joy_node", True),
        ("bench/run.py", True),
        (".venv/lib/python3.11/site-packages/ray/_private/workers/default_worker.py", True),
        ("src/lane_course/scripts/lane.py", False),
        ("devel/lib/lane_course/lane.py", False),
        (".venv/bin/pytest", False),
        ("../elsewhere/src/bullet_web/web", False),
        ("", False),
        ("-c", False),
    ],
)
def test_programs_of_paddock_get_the_cv2_without_windows(path, is_own):
    argv = os.path.join(ROOT, path) if len(path) > 2 else path
    found = Path(start("-c", f"import sys; sys.argv[0] = {argv!r}; {WHICH}"))
    assert (HEADLESS in found.parents) == is_own
    if not is_own:
        assert Path(ROOT) not in found.parents


def test_a_module_of_paddock_is_its_program(tmp_path):
    package = tmp_path / "paddock_gym"
    package.mkdir()
    (package / "__init__.py").write_text(WHICH)
    (package / "mine.py").write_text("")
    text = start("-m", "paddock_gym.mine", PYTHONPATH=f"{START}:{tmp_path}")
    assert text.startswith(str(HEADLESS))


def test_the_systems_python_and_its_sitecustomize(tmp_path):
    (tmp_path / "sitecustomize.py").write_text("print('theirs')")
    text = start("-c", WHICH, python="/usr/bin/python3", PYTHONPATH=f"{START}:{tmp_path}")
    assert text.startswith("theirs\n/usr/lib")


def test_libraries_that_run_without_a_screen_do():
    code = "import os, sys\nimport PyQt5, pygame\nprint(os.environ['{}'])"
    assert start("-c", code.format("QT_QPA_PLATFORM")).endswith("offscreen")
    assert start("-c", code.format("SDL_VIDEODRIVER")).endswith("dummy")
    told = "import os, PyQt5; print(os.environ.get('QT_QPA_PLATFORM'))"
    assert start("-c", told, DISPLAY=":1") == "None"
    assert start("-c", told, QT_QPA_PLATFORM="vnc") == "vnc"
    app = "from PyQt5.QtWidgets import QApplication as A; print(A([]).platformName())"
    assert start("-c", app) == "offscreen"


@pytest.mark.parametrize("named, known", [("pyqt", "pyqt5"), ("pyside", "pyside2"), ("x", "x")])
def test_qtpy_gets_the_binding_by_its_own_name(tmp_path, named, known):
    """It refuses the name that python_qt_binding sets: rqt_plot ended."""
    (tmp_path / "qtpy.py").write_text("import os; print(os.environ.get('QT_API'))")
    path = f"{START}:{tmp_path}"
    assert start("-c", "import qtpy", PYTHONPATH=path, QT_API=named) == known
    without = "import os; os.environ.pop('QT_API', None); import qtpy"
    assert start("-c", without, PYTHONPATH=path) == "None"


class Cv2:
    """What of cv2 windows without a screen use."""

    WND_PROP_VISIBLE = 4
    error = RuntimeError
    imshow = namedWindow = createTrackbar = None


@pytest.fixture
def windows():
    return paddock_windows.Kept(Cv2)


def test_trackbars_keep_their_values_within_their_bounds(windows):
    heard = []
    windows.namedWindow("a")
    windows.createTrackbar("low", "a", 3, 10, heard.append)
    assert windows.getTrackbarPos("low", "a") == 3 and heard == []
    for value, kept in ((7, 7), (12, 10), (-1, 0)):
        windows.setTrackbarPos("low", "a", value)
        assert windows.getTrackbarPos("low", "a") == heard[-1] == kept
    windows.setTrackbarMin("low", "a", 2)
    windows.setTrackbarPos("low", "a", 0)
    assert heard[-1] == 2
    assert windows.getTrackbarPos("high", "a") == windows.getTrackbarPos("low", "b") == -1


def test_a_window_is_visible_until_it_is_destroyed(windows):
    import numpy as np

    windows.imshow("a", np.zeros((6, 8), np.uint8))
    assert windows.getWindowProperty("a", Cv2.WND_PROP_VISIBLE) == 1.0
    assert windows.getWindowImageRect("a") == (0, 0, 8, 6)
    assert windows.waitKey(1) == windows.pollKey() == -1
    windows.destroyAllWindows()
    assert windows.getWindowProperty("a", Cv2.WND_PROP_VISIBLE) == 0.0
    with pytest.raises(RuntimeError, match="'a' gets no picture"):
        windows.imshow("a", None)


@pytest.mark.parametrize(
    "kind, value, shown",
    [("uint8", 200, 200), ("uint16", 51200, 200), ("int8", 72, 200), ("float32", 0.5, 127),
     ("float64", 7.0, 255), ("float32", "nan", 0), ("bool", True, 1)],
)  # fmt: skip
def test_pictures_have_the_colors_in_which_cv2_shows_them(monkeypatch, kind, value, shown):
    import numpy as np
    import rospy

    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(7))
    window = paddock_windows.Window("Lane: 1")
    for shape, encoding in (((2, 3), "mono8"), ((2, 3, 3), "bgr8"), ((2, 3, 4), "bgra8")):
        window.show(np.full(shape, value, kind)[::-1])
        message = window.message()
        assert (message.encoding, message.header.frame_id) == (encoding, "Lane: 1")
        assert set(message.data) == {shown} and len(message.data) == message.step * 2


def test_calls_of_all_threads_are_made_in_one():
    import threading

    threads = set()

    class Real(Cv2):
        @staticmethod
        def imshow(name):
            threads.add(threading.current_thread().name)
            if name == "bad":
                raise ValueError(name)
            return name

        waitKey = waitKeyEx = staticmethod(lambda delay: threads.add(delay) or -1)

    windows = paddock_windows.InOneThread(Real)
    answers = []
    others = [threading.Thread(target=lambda: answers.append(windows.imshow("a"))) for _ in "abc"]
    for other in others:
        other.start()
    for other in others:
        other.join()
    assert answers == ["a"] * 3 and windows.waitKey(25) == -1
    with pytest.raises(ValueError, match="bad"):
        windows.imshow("bad")
    assert "cv2" in threads and not any(str(each).startswith("Thread") for each in threads)


WINDOW = """
import sys
sys.argv[0] = {program!r}
from PyQt5 import QtCore, QtGui, QtWidgets

application = QtWidgets.QApplication(["test"])
slider, bar, spin = QtWidgets.QSlider(), QtWidgets.QProgressBar(), QtWidgets.QSpinBox()
slider.setRange(0, 250 / 2.5)
slider.valueChanged.connect(bar.setValue)
slider.setValue(42.9)
spin.setValue(7.5)
spin.resize(80.9, 31)
image = QtGui.QPixmap(9, 9)
painter = QtGui.QPainter(image)
painter.fillRect(0.5, 0, 9, 9, QtCore.Qt.red)
painter.end()
timer = QtCore.QTimer()
timer.start(1e3 / 50)
print(slider.maximum(), slider.value(), bar.value(), spin.value(), spin.width(), timer.interval())
try:
    slider.setValue("42")
except TypeError as error:
    print(error)
"""


def test_windows_of_users_may_have_numbers_with_a_point():
    """joint_state_publisher_gui of Debian 12 sets a slider to RANGE / 2."""
    numbers, error = start("-c", WINDOW.format(program="window.py")).splitlines()
    assert numbers == "100 42 42 7 80 20"
    assert "has unexpected type 'str'" in error


@pytest.mark.skipif(sys.version_info < (3, 10), reason="older ones take them")
def test_windows_of_paddock_are_as_they_are():
    program = WINDOW.format(program=os.path.join(ROOT, "bench", "run.py"))
    with pytest.raises(subprocess.CalledProcessError) as error:
        start("-c", program, QT_QPA_PLATFORM="offscreen")
    assert "argument 2 has unexpected type 'float'" in error.value.stderr


def test_what_qt_is_asked_for_is_there():
    code = "import importlib, paddock_qt\nfor name in paddock_qt.METHODS:\n"
    code += "    paddock_qt.install(importlib.import_module(name))"
    start("-c", code)
