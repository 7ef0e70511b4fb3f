"""Python half of the package, read by catkin_python_setup."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

PARTS = ("", ".estimate", ".inputs", ".navsat")

setup(
    **generate_distutils_setup(
        packages=["robot_localization" + part for part in PARTS], package_dir={"": "src"}
    )
)
