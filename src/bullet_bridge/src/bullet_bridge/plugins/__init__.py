"""What the families of plugins and sensors do in ROS; importing this enters each file of it."""

import importlib
import pkgutil

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
