"""dynamic_reconfigure: servers whose first values are the simulation's."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import rospy
from dynamic_reconfigure.server import Server


class ValuesServer(Server):
    """A server whose first values are the simulation's, not those of the parameter server.

    As roscpp's it tells the first as they are, and holds all within the bounds at every change.

    Args:
        config: module that dynamic_reconfigure's generator would make.
        values: name -> first value.
        callback: as of Server; not called before the server is made.
        namespace: of its topics, service and parameters, e.g. '/bot/arm/pid'.
    """

    def __init__(
        self,
        config: Any,
        values: Mapping[str, Any],
        callback: Callable[[Any, int], Any],
        namespace: str,
    ) -> None:
        self._values = values
        super().__init__(config, self._begin, namespace)
        self.callback = callback

    def _copy_from_parameter_server(self) -> None:
        """The parameters do not count."""

    def _begin(self, config: Any, _level: int) -> Any:
        """The first values, beyond the bounds as well."""
        config.update(self._values)
        return config

    def _set_callback(self, request: Any) -> Any:
        """Change values; those of other names and types are ignored and named, as by roscpp."""
        config, kinds = request.config, self.type.type
        config.groups = []  # which of them a user interface shows
        ignored: list[Any] = []
        for field in ("bools", "ints", "strs", "doubles"):
            kept: list[Any] = []
            for value in getattr(config, field):
                kind = kinds.get(value.name)
                fits = kind is not None and (kind == "str") == (field == "strs")
                (kept if fits else ignored).append(value)
            setattr(config, field, kept)
        if ignored:
            names = ", ".join(f"'{value.name}'" for value in ignored[:5])
            rospy.logerr("%s: no parameter has this name and type: %s", self.ns, names)
        return super()._set_callback(request)

    def close(self) -> None:
        """Shut down the service and unregister the topics."""
        self.set_service.shutdown("the controller is unloaded")
        self.descr_topic.unregister()
        self.update_topic.unregister()

    unregister = close
