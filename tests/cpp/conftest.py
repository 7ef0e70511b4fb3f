"""Each file with a workspace is a node, as in tests/long."""

from node_fixture import node  # noqa: F401
