"""Prints whether a condition of a package.xml (REP 149) holds: True or False.

Run by the system's Python, as catkin_pkg is Debian's, with the condition and NAME=VALUE ...
Exits 1, with the reason, where it is no condition, and 3 where there is no catkin_pkg.
"""

import sys


def main(condition, *variables):
    """Returns the exit code."""
    try:
        from catkin_pkg.condition import evaluate_condition
    except ImportError:
        return 3
    try:
        print(evaluate_condition(condition, dict(pair.split("=", 1) for pair in variables)))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
