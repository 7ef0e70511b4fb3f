"""The PID's configuration type for dynamic_reconfigure: names, ranges and defaults of its gains.

Servers take this module as their `type`. It is written by hand as a .cfg generator would write it.
"""

# name, type, default, least, greatest, description; every one of level 1
_PARAMETERS = (
    ("p", "double", 10.0, -100000.0, 100000.0, "Proportional gain."),
    ("i", "double", 0.1, -1000.0, 1000.0, "Integral gain."),
    ("d", "double", 1.0, -1000.0, 1000.0, "Derivative gain."),
    ("i_clamp_min", "double", -10.0, -1000.0, 0.0, "Lower bound of the integral term."),
    ("i_clamp_max", "double", 10.0, 0.0, 1000.0, "Upper bound of the integral term."),
    ("antiwindup", "bool", False, False, True, "Bound the stored integral, too."),
)

config_description = {
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
    "parameters": [
        {
            "name": row[0],
            "type": row[1],
            "default": row[2],
            "min": row[3],
            "max": row[4],
            "description": row[5],
            "level": 1,
            "edit_method": "",
        }
        for row in _PARAMETERS
    ],
}
min = {row[0]: row[3] for row in _PARAMETERS}
max = {row[0]: row[4] for row in _PARAMETERS}
defaults = {row[0]: row[2] for row in _PARAMETERS}
level = {row[0]: 1 for row in _PARAMETERS}
type = {row[0]: row[1] for row in _PARAMETERS}
all_level = 1
