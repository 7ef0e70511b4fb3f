"""The shader programs and their GLSL.

Positions are relative to an origin near the camera, so that single precision is enough far from
the world's.
"""
