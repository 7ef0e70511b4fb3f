"""Run by .venv's Python at the end of step 2: whether what Paddock imports is there.

Usage: python check_imports.py VENV
"""

import sys

import av  # noqa: F401
import cv2  # noqa: F401
import cv_bridge  # noqa: F401
import numpy
import pybullet  # noqa: F401
import pytest  # noqa: F401
import rospy  # noqa: F401
import xacro  # noqa: F401
import yaml  # noqa: F401
from PyQt5 import QtWidgets  # noqa: F401

if numpy.__file__.startswith(sys.argv[1]):
    sys.exit(f"numpy is {numpy.__version__} of .venv; Debian's has to stay, cv_bridge needs it")
