"""The gym needs no ROS: every module but the driver's node can be imported where there is none."""

import pathlib
import re
import subprocess
import sys

import paddock_gym.envs

LEARNING = ("training", "policy.export", "sweep.cli", "sweep.study")  # need torch, Optuna or Ray
SCRIPT = """
import importlib, sys
for name in ("rospy", "rosgraph", "roslib", "roslaunch", "genpy", "std_msgs", "cv_bridge"):
    sys.modules[name] = None
for module in sys.argv[1:]:
    try:
        importlib.import_module(module)
    except ImportError as error:
        print(f"{module}: {error}")
"""


def test_modules_can_be_imported_without_ros():
    base = pathlib.Path(paddock_gym.envs.__file__).parents[1]
    names = [
        re.sub(r"\.__init__$", "", ".".join(path.relative_to(base).with_suffix("").parts))
        for path in sorted(base.rglob("*.py"))
        if path != base / "__init__.py"
    ]
    wanted = [name for name in names if not name.startswith(("driver", *LEARNING))]
    assert {"course", "observations", "envs.run"} <= set(wanted) and len(wanted) > 35
    command = [sys.executable, "-c", SCRIPT, *(f"paddock_gym.{name}" for name in wanted)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == ""
