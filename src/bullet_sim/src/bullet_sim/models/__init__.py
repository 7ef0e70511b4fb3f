"""Loaded models: links, joints, masses, forces, and loading a description."""
