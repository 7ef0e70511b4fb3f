"""What the families of plugins and sensors do in ROS; importing this enters them all."""

from bullet_bridge.plugins import (
    actors,
    bases,
    cameras,
    contacts,
    drives,
    forces,
    gazebo,
    grasping,
    harness,
    lidars,
    measurements,
    servos,
    transforms,
)

__all__ = [
    "actors",
    "bases",
    "cameras",
    "contacts",
    "drives",
    "forces",
    "gazebo",
    "grasping",
    "harness",
    "lidars",
    "measurements",
    "servos",
    "transforms",
]
