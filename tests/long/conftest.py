"""Each file with a LAUNCH is a node; small clones and checkouts as in tests/unit."""

from clone_fixtures import clone, completed, interrupted, package_index  # noqa: F401
from node_fixture import node  # noqa: F401
from plugin_rig import project  # noqa: F401
from users_rig import sources  # noqa: F401
