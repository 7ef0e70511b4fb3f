"""Prints a script that completes the commands of ./run in bash.

In one shell, or for good in ~/.bashrc, with the path of this clone:
  source <(./run completion)
  source <(/path/to/paddock/run completion)

TAB then knows commands, options, drivers, tracks, shapes, tests and launch arguments. It asks the
./run that is on the command line, so one script serves every clone.
"""

import argparse

from commands.completion import SCRIPT, candidates


def add_arguments(parser):
    """Declares what the script itself asks with."""
    parser.add_argument("--line", help=argparse.SUPPRESS)
    parser.add_argument("--breaks", default=":=", help=argparse.SUPPRESS)


def run(options, _rest):
    """Prints the script, or what the end of a line can become."""
    if options.line is None:
        print(SCRIPT, end="")
    else:
        print("\n".join(candidates(options.line, options.breaks)))
