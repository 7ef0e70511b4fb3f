"""Fixtures of the project's own tests."""

from plugin_rig import project  # noqa: F401
from users_rig import sources  # noqa: F401
