"""Loads the tests' plugins and sets what every test finds in its environment."""

import os
import signal
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
OPENCV = ROOT / ".venv" / "opencv"  # the cv2 of Paddock's own programs
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "plugins"), str(OPENCV)]
sys.pycache_prefix = str(ROOT / ".cache" / "pycache")  # compiled once, not in src
sys.dont_write_bytecode = False

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as shells start what is in the background
    signal.signal(signal.SIGINT, signal.default_int_handler)

pytest_plugins = ["selection", "isolation", "sketches"]

for _name in ("ROS_HOSTNAME", "PYTHONDONTWRITEBYTECODE"):
    os.environ.pop(_name, None)
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as ./run sets it
os.environ.update(
    PYTHONPYCACHEPREFIX=sys.pycache_prefix,
    QT_QPA_PLATFORM="offscreen",
    ROS_HOME=str(ROOT / "test-results" / "ros_home"),
    PADDOCK_NICENESS="0",  # worlds of tests that run side by side leave their nodes processors
    ROS_IP="127.0.0.1",
)
_start = sys.modules.get("sitecustomize")
if hasattr(_start, "QT"):  # windows tested here are as strict as Paddock's programs
    _start.Finder.wanted.difference_update(_start.QT)
_packages = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
if str(ROOT / "tests") not in _packages:
    os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join([str(ROOT / "tests"), *_packages])
