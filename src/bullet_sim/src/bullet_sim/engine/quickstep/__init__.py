"""Rigid bodies in maximal coordinates, stepped as Gazebo Classic steps them, compiled by numba."""
