"""Python half of the package: read by catkin_python_setup, and by `pip install ./src/paddock_gym`.

With pip the wheel also contains the packages that paddock_gym needs, and the tracks and meshes. A
source distribution has them in the folder `parts`, see packaging/standalone.py.
"""

import glob
import os
import tempfile

from setuptools import find_packages, setup

NEEDED = ("bullet_sim", "cybertruck", "deepracer_control", "paddock_common", "track_model")
SHARED = {  # folders of packages
    "cybertruck": ("config", "meshes", "urdf", "worlds"),
    "track_model": ("meshes", "tracks", "urdf", "worlds"),
}
REQUIRES = (
    "glcontext>=2.3",
    "gymnasium>=0.29.1,<2",
    "moderngl>=5.8,<6",
    "numba>=0.57",
    "numpy>=1.23.5,<3",
    "onnxruntime>=1.17",
    "opencv-python-headless>=4.8,<5",
    "pillow",
    "pycollada",
    "PyYAML",
    "scipy",
    "shapely>=2",
    "trimesh",
    "xacro>=2",
)
CLUSTER = ("ray==2.60.0; python_version >= '3.10'", "ray==2.10.0; python_version < '3.10'")
SWEEP = ("optuna==5.0.0; python_version >= '3.10'", "optuna==4.5.0; python_version < '3.10'")
TRAINING = (
    "matplotlib",
    "onnx>=1.12",
    "stable-baselines3==2.4.1; python_version < '3.13'",
    "stable-baselines3>=2.6,<3; python_version >= '3.13'",  # which allow numpy 2
    "torch>=1.13",
)
TENSORBOARD = ("tensorboard>=2.14",)  # its logs of a training
SEVERAL = ("pettingzoo>=1.24",)  # several robots that learn in one world
BULLET = ("pybullet==3.2.7",)  # the solver "bullet", and shapes that "ode" leaves to it
PARTS = "parts" if os.path.isdir("parts") else ".."  # of a source distribution, or of the clone


def standalone():
    """Arguments of setup() for pip."""
    packages, folders = find_packages("src"), {"": "src"}
    for name in NEEDED:
        folder = os.path.join(PARTS, name, "src")
        packages += [package for package in find_packages(folder) if package.split(".")[0] == name]
        folders[name] = os.path.join(folder, name)
    data = []
    for package, shared in SHARED.items():
        for folder in shared:
            files = sorted(filter(os.path.isfile, glob.glob(f"{PARTS}/{package}/{folder}/*")))
            data.append((os.path.join("share", package, folder), files))
    temporary = tempfile.mkdtemp(prefix="paddock_gym_")  # nothing is left in the sources
    return {
        "name": "paddock_gym",
        "version": "0.2.0",
        "description": "Gymnasium environments on Paddock's simulation core",
        "license": "BSD-3-Clause",
        "python_requires": ">=3.8",
        "packages": packages,
        "package_dir": folders,
        "data_files": data,
        "install_requires": REQUIRES,
        "extras_require": {
            "training": TRAINING,
            "cluster": CLUSTER,
            "sweep": SWEEP,
            "bullet": BULLET,
            "several": SEVERAL,
            "tensorboard": TENSORBOARD,
        },
        "options": {"build": {"build_base": temporary}, "egg_info": {"egg_base": temporary}},
    }


def catkin():
    """Arguments of setup() for catkin."""
    from catkin_pkg.python_setup import generate_distutils_setup

    return generate_distutils_setup(packages=find_packages("src"), package_dir={"": "src"})


setup(**(standalone() if os.environ.get("PADDOCK_STANDALONE") else catkin()))
