"""The engine 'bullet', and PyBullet beside the engine 'ode'; nothing else imports pybullet."""

from bullet_sim.files import silenced

with silenced():  # PyBullet prints a banner
    import pybullet as _pybullet

__all__ = ["_pybullet"]
