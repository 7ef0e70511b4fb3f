"""The commands of ./run: name and summary, in the order in which the help lists them.

NAME is the module commands/subcommands/NAME.py (with _ for -). A new command is one line here and
that file.
On a machine without python3, ./run reads this table with sed, so each entry stays on one line.
"""

COMMANDS = {
    "setup": "install and build what is missing, start nothing",
    "demo": "drive through the real window without a display; images and path go to out/",
    "lap": "drive a lap by one of the drivers; film, path and figures go to out/lap/",
    "train": "learn to drive a track; policy, film and curves go to out/train/",
    "evaluate": "drive laps of a trained policy, and of other drivers to compare with",
    "drive-by": "start a launch file and command its robot by a policy of Paddock/Robot-v0",
    "sweep": "try many settings of a training, or many gains; table and plots go to out/sweep/",
    "cluster": "make this machine a node of a Ray cluster, for ./run train --ray",
    "test": "run all tests, or: unit, lint, ros, or part of a test's name",
    "bare": "run a command, such as the tests, on a Debian with nothing installed (as root)",
    "world": "start the world and the car, without a window",
    "teleop": "start the window alone, for a world that runs already",
    "truck": "start the Cyber Truck with its trailer in a yard, or back its trailer",
    "web": "show the world on a page in a browser: 3-D, driving by keys or thumbs, cameras, plots",
    "map": "write the map of a world without SLAM, or the world of a map",
    "replay": "make a replay, an HTML file that any browser opens, of a rosbag",
    "desk": "show the window and rviz in a browser, from a machine without a screen",
    "container": "run any of these in a container, for systems without a ROS 1",
    "check": "start a launch file of yours and tell what works, and why the rest does not",
    "ci": "build and test packages of yours as a CI does it: JUnit files, logs, films",
    "deps": "name the Debian packages that package.xml files ask for, and what Debian lacks",
    "add": "bring ROS packages from their sources: navigation, gmapping, a URL ...; build them",
    "exec": "run a command with the environment and the workspace active",
    "bench": "measure speed, latency and memory",
    "soak": "run everything under faults for minutes or hours; a page goes to out/soak/",
    "docs": "build the site of the documents, with a search, and show it in a browser",
    "version": "print the version and what it runs on",
    "completion": "print a script that completes these commands in bash",
}
DEFAULT = "drive"  # the module for no command, or launch arguments alone
