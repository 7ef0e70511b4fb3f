"""Build backend of `pip install ./src/paddock_gym`: setuptools, told that there is no catkin.

A source distribution also has what paddock_gym takes from the folders beside it, in `parts`.
"""

import ast
import os
import shutil
import tempfile

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403

os.environ["PADDOCK_STANDALONE"] = "1"  # read by setup.py
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.so", "*.nb[ic]", "test", "build", "*.egg-info")


def needed(setup):
    """Names of the packages beside this one in NEEDED of a setup.py."""
    with open(setup, encoding="utf-8") as file:
        for node in ast.parse(file.read()).body:
            if isinstance(node, ast.Assign) and node.targets[0].id == "NEEDED":
                return ast.literal_eval(node.value)
    raise ValueError(f"{setup} has no NEEDED")


def build_sdist(sdist_directory, config_settings=None):
    """Builds the source distribution in a copy, in which all parts are."""
    goal, here = os.path.abspath(sdist_directory), os.getcwd()
    with tempfile.TemporaryDirectory(prefix="paddock_gym_") as folder:
        copy = os.path.join(folder, "paddock_gym")
        shutil.copytree(here, copy, ignore=LEFT_OUT)
        parts = os.path.join(copy, "parts")
        if not os.path.isdir(parts):
            for name in needed("setup.py"):
                beside = os.path.join(os.pardir, name)
                shutil.copytree(beside, os.path.join(parts, name), ignore=LEFT_OUT)
        with open(os.path.join(copy, "MANIFEST.in"), "w", encoding="utf-8") as manifest:
            manifest.write("graft parts\ngraft packaging\n")
        os.chdir(copy)
        try:
            return build_meta.build_sdist(goal, config_settings)
        finally:
            os.chdir(here)
