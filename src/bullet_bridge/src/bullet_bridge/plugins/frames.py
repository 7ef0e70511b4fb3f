"""Frames of plugins with the prefix that the parameter tf_prefix gives them, as tf resolves it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import rosgraph
from bullet_sim.plugins.rules import NEAREST, OWN, FrameName, FramePrefix

from bullet_bridge.transport.parameters import nearest

PARAMETER = "tf_prefix"


def parameter(prefix: FramePrefix) -> str:
    """Value of the parameter tf_prefix for a plugin's frames; empty: there is none.

    As roscpp's getParam() into a string, it ignores values of other types.
    """
    try:
        if prefix.source == NEAREST:
            value = nearest(prefix.namespace, PARAMETER)
        elif prefix.source == OWN or not prefix.namespace:
            name = f"/{prefix.namespace}/{PARAMETER}".replace("//", "/")
            value = rosgraph.Master("/").getParam(name)
        else:
            value = ""
    except (OSError, rosgraph.MasterException):  # there is no such parameter, or no master
        return ""
    return value if isinstance(value, str) else ""


def with_prefixes(spec: Any, look_up: Callable[[FramePrefix], str] = parameter) -> Any:
    """The specification of a plugin with whole names in place of its FrameNames.

    Args:
        look_up: value of the parameter for a FramePrefix; is asked once for each.
    """
    known: dict[FramePrefix, str] = {}

    def whole(value: Any) -> Any:
        if isinstance(value, FrameName):
            if value.prefix is None:
                return value
            if value.prefix not in known:
                known[value.prefix] = value.prefix.of(look_up(value.prefix))
            return FrameName(known[value.prefix] + value)
        if isinstance(value, Mapping):
            return {key: whole(item) for key, item in value.items()}
        return tuple(map(whole, value)) if isinstance(value, tuple) else value

    if not is_dataclass(spec) or isinstance(spec, type):
        return spec
    given = {field.name: getattr(spec, field.name) for field in fields(spec)}
    changes = {name: whole(value) for name, value in given.items() if _has_frames(value)}
    return replace(spec, **changes) if changes else spec


def _has_frames(value: Any) -> bool:
    if isinstance(value, Mapping):
        return any(map(_has_frames, value.values()))
    if isinstance(value, tuple):
        return any(map(_has_frames, value))
    return isinstance(value, FrameName) and value.prefix is not None
