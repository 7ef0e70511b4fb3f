"""Runs one observer: observe.py NAME ARGUMENTS. Answers are JSON, one line each."""

import importlib
import os
import sys

if __name__ == '__main__':
    importlib.import_module(f'observers.{sys.argv[1]}').main(*sys.argv[2:])
    sys.stdout.flush()
    os._exit(0)     # without rospy's farewell to a master that may be gone
