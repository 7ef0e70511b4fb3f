"""Configuration types for dynamic_reconfigure, as a .cfg generator would write them."""

from __future__ import annotations

from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any


def describe(parameters: Iterable[tuple[str, str, Any, Any, Any, str]]) -> SimpleNamespace:
    """Returns what a configuration's module is, to dynamic_reconfigure's servers.

    Args:
        parameters: (name, type, default, minimum, maximum, description) of each; all of level 1.

    Returns:
        config_description, min, max, defaults, level, type and all_level.
    """
    rows = [
        {
            "name": name,
            "type": type_name,
            "default": default,
            "min": minimum,
            "max": maximum,
            "description": description,
            "level": 1,
            "edit_method": "",
        }
        for name, type_name, default, minimum, maximum, description in parameters
    ]
    group = {
        "name": "Default",
        "type": "",
        "state": True,
        "cstate": "true",
        "id": 0,
        "parent": 0,
        "class": "DEFAULT",
        "parentclass": "",
        "parentname": "Default",
        "field": "default",
        "upper": "DEFAULT",
        "lower": "groups",
        "groups": [],
        "parameters": rows,
    }
    columns = {"min": "min", "max": "max", "defaults": "default", "level": "level", "type": "type"}
    of_columns = {name: {row["name"]: row[key] for row in rows} for name, key in columns.items()}
    return SimpleNamespace(config_description=group, all_level=1, **of_columns)
