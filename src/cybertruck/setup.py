from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(
    packages=["cybertruck", "cybertruck.backing", "cybertruck.goal", "cybertruck.meshes",
              "cybertruck.plot", "cybertruck.teleop", "cybertruck.trailer"],
    package_dir={"": "src"}))
