"""Runs one observer: observe.py MODULE.FUNCTION ARGUMENTS. Answers are JSON, one line each."""

import importlib
import os
import sys

from observers import graph

if __name__ == "__main__":
    answers = os.fdopen(os.dup(1), "w")  # answers only: renderers and rospy print on stdout
    os.dup2(2, 1)
    graph.answer_on(answers)
    module, _, function = sys.argv[1].partition(".")
    getattr(importlib.import_module(f"observers.{module}"), function)(*sys.argv[2:])
    answers.flush()
    os._exit(0)  # without rospy's farewell to a master that may be gone
