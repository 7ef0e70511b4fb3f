"""Loaded models: links, joints, masses, forces, and how a description becomes one."""
