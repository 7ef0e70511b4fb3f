"""Gazebo's own libraries in the process, for plugins in C++: see docs/cpp_plugins.md."""
