"""Tells catkin where the Python module is."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=["control_toolbox", "control_toolbox.cfg"], package_dir={"": "src"}
    )
)
