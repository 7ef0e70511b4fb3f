#!/usr/bin/env python3
"""xacro under the name it had before ROS Noetic: $(find xacro)/xacro.py."""

import os
import runpy

if __name__ == "__main__":
    runpy.run_path(
        os.path.join(os.path.dirname(os.path.realpath(__file__)), "xacro"), run_name="__main__"
    )
