"""Build backend of `pip install ./src/paddock_gym`: setuptools, told that there is no catkin."""

import os

from setuptools.build_meta import *  # noqa: F403

os.environ["PADDOCK_STANDALONE"] = "1"  # read by setup.py
