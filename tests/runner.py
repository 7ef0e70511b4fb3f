"""Runs every test of the project: `./run test`, which sets the environment, starts this file."""

import sys

from runner.main import main  # the package beside this file, which goes before it

if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
