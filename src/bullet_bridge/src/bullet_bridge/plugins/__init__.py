"""What the families of plugins and sensors do in ROS; importing this enters them all."""

from bullet_bridge.plugins import cameras, drives, lidars, measurements, transforms

__all__ = ["cameras", "drives", "lidars", "measurements", "transforms"]
