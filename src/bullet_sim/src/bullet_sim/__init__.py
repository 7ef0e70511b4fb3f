"""Pure simulation core of Paddock: no ROS import, a plain Python library.

The names below are imported when they are first used: `from bullet_sim import World` costs what
`from bullet_sim.world import World` does, and `import bullet_sim` nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

_MODULES = {  # name -> module that has it
    "World": "world",
    "Engine": "engine",
    "Pose": "pose",
    "SimError": "errors",
    "ModelError": "errors",
    "WorldError": "errors",
    "ControllerError": "errors",
    "CommandError": "errors",
    "RenderError": "errors",
    "parse_urdf": "formats.urdf",
    "parse_world": "formats.sdf.world",
    "parse_model": "formats.sdf.world",
    "ground_plane": "formats.sdf.world",
    "RenderClient": "render.client",
    "CameraRequest": "render.request",
    "Quality": "render.request",
    "Lidar": "sensors.lidar",
    "Controller": "controllers",
    "ControllerConfig": "controllers",
    "CONTROLLERS": "controllers",
}
__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    """Import a public name (PEP 562).

    Raises:
        AttributeError: no such name.
    """
    module = _MODULES.get(name)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{module}"), name)


def __dir__() -> list[str]:
    """The public names with those that are imported."""
    return sorted({*globals(), *__all__})
