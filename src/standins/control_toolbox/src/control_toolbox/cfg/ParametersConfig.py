"""The PID's configuration type for dynamic_reconfigure: names, ranges and defaults of its gains.

Servers take this module as their `type`. It is written by hand as a .cfg generator would write it.
"""

from paddock_common.reconfigure import describe

# name, type, default, minimum, maximum, description; every one of level 1
_PARAMETERS = (
    ("p", "double", 10.0, -100000.0, 100000.0, "Proportional gain."),
    ("i", "double", 0.1, -100000.0, 100000.0, "Integral gain."),
    ("d", "double", 1.0, -1000.0, 1000.0, "Derivative gain."),
    ("i_clamp_min", "double", -10.0, -100000.0, 0.0, "Lower bound of the integral term."),
    ("i_clamp_max", "double", 10.0, 0.0, 100000.0, "Upper bound of the integral term."),
    ("antiwindup", "bool", False, False, True, "Bound the stored integral, too."),
)

globals().update(vars(describe(_PARAMETERS)))
