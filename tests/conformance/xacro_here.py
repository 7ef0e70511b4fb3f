"""A plugin of pytest: the xacro library as the stand-in's command patches it."""

import runpy
from pathlib import Path

runpy.run_path(str(Path(__file__).resolve().parents[2] / "src" / "standins" / "xacro" / "xacro"))
