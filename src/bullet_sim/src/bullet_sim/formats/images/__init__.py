"""Drawn images that stand for those of Gazebo's standard materials where they are not installed."""
