"""Runs one observer: observe.py MODULE.FUNCTION ARGUMENTS. Answers are JSON, one line each."""

import importlib
import os
import sys

if __name__ == "__main__":
    sys.stdout = os.fdopen(os.dup(1), "w")  # answers only: renderers print on descriptor 1
    os.dup2(2, 1)
    module, _, function = sys.argv[1].partition(".")
    getattr(importlib.import_module(f"observers.{module}"), function)(*sys.argv[2:])
    sys.stdout.flush()
    os._exit(0)  # without rospy's farewell to a master that may be gone
