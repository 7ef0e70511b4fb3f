"""The sections of the bench: one module each, named in SECTIONS.

A section's module has two functions:

    measure(quick, log) -> dict     starts what it needs and returns figures, ready for JSON. quick:
                                    shorter and fewer. log: file for what programs print. Raises
                                    figures.BenchError when a run gave no figures; a part that
                                    failed while others did not is told in figures["errors"], a
                                    dict of part -> why.
    rows(figures) -> Rows           what the table says of these figures, see report.Row; a Row
                                    with a value is also a result, see results.py.

Whatever is a ratio comes from pairs.alternate.
"""

import importlib

# Name of the module -> what it measures.
SECTIONS = {
    "start": "roslaunch to the first joint state, image and all controllers",
    "efficiency": "the bridge running free over bare stepping, and who had the processors",
    "driving": "camera, pace and processor time at real time",
    "camera": "images, bare and received, over PyBullet's EGL renderer",
    "latency": "command to the joint states that show it",
    "navigation": "mapping and navigating at real time, truck and TurtleBot3",
    "scale": "1 to 32 cars with a lidar each",
    "learning": "actions a second of the learner's environments over bare stepping",
    "actions": "actions a second of the learner's environments, absolute and of a core",
    "returns": "returns of drivers in the learner's environment: by chance, pure pursuit, trained",
    "gym_gap": "a lap of the same policy in the gym and over ROS",
    "peers": "the learner's environments beside other simulators of cars",
    "gym_steps": "what the learner's car does with physics steps of 0.5 to 4 ms",
    "solver": "steps and scans with the solver ode over bullet's, in worlds that were slow",
    "beside_gazebo": "worlds with one cause of slowness each, beside Gazebo's recorded pace",
}


def section(name):
    """The module of a section."""
    return importlib.import_module(f"sections.{name}")
