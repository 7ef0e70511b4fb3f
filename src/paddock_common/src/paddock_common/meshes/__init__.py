"""Meshes made by scripts: solids of flat faces, written as Wavefront OBJ with one colour each."""
