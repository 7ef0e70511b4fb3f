"""The physics' configuration type for dynamic_reconfigure: names, ranges, defaults.

Servers take this module as their `type`. It is written by hand as a .cfg generator would write it;
the upper bound of max_update_rate is above upstream's 1000, which is real time here.
"""

from paddock_common.reconfigure import describe

# name, type, default, min, max, description; every one of level 1
_PARAMETERS = (
    ("time_step", "double", 0.001, 0.0, 10.0, "Physics step [s]."),
    ("max_update_rate", "double", 1000.0, 0.0, 1e6, "Steps per wall second [Hz]; 0: no limit."),
    ("gravity_x", "double", 0.0, -100.0, 100.0, "Gravity along x [m/s^2]."),
    ("gravity_y", "double", 0.0, -100.0, 100.0, "Gravity along y [m/s^2]."),
    ("gravity_z", "double", -9.8, -100.0, 100.0, "Gravity along z [m/s^2]."),
    ("auto_disable_bodies", "bool", False, False, True, "Of ODE, without effect."),
    ("sor_pgs_precon_iters", "int", 0, 0, 10000, "Is kept, without effect."),
    ("sor_pgs_iters", "int", 50, 0, 10000, "Iterations of the constraint solver per step."),
    ("sor_pgs_w", "double", 1.3, 0.0, 5.0, "Factor of each correction of the constraint solver."),
    ("sor_pgs_rms_error_tol", "double", 0.0, -1.0, 10000.0, "Of ODE, without effect."),
    ("cfm", "double", 0.0, 0.0, 10.0, "Constraint force mixing of joints [s/kg]."),
    ("erp", "double", 0.2, 0.0, 10.0, "Fraction of a joint's error that is corrected in a step."),
    ("contact_surface_layer", "double", 0.001, 0.0, 10.0, "Is kept, without effect [m]."),
    ("contact_max_correcting_vel", "double", 100.0, 0.0, 1e7, "Of contacts [m/s]; of new models."),
    ("max_contacts", "int", 100, 0, 10000000, "Of a pair of shapes; of new models."),
)

globals().update(describe(_PARAMETERS))
