"""Fixtures of the project's own tests."""

from clone_fixtures import clone, completed, interrupted, package_index  # noqa: F401
from plugin_rig import project  # noqa: F401
from users_rig import sources  # noqa: F401
