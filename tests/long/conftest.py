"""Each file with a LAUNCH is a node."""

from node_fixture import node  # noqa: F401
