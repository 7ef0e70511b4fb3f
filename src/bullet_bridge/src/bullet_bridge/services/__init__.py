"""Gazebo's services: models, links, joints, physics."""
