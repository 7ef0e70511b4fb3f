"""dynamic_reconfigure: servers whose first values are the simulation's."""

from __future__ import annotations

import types
from collections.abc import Callable, Mapping
from typing import Any

import rospy
from dynamic_reconfigure.server import Server


def widened(config: Any, values: Mapping[str, Any]) -> types.SimpleNamespace:
    """A configuration's module with ranges that include the first `values`."""
    made = types.SimpleNamespace(
        **{
            name: getattr(config, name)
            for name in ("config_description", "defaults", "level", "type", "all_level")
        }
    )
    made.min = {name: min(low, values[name]) for name, low in config.min.items()}
    made.max = {name: max(high, values[name]) for name, high in config.max.items()}
    return made


class ValuesServer(Server):
    """A server whose first values are the simulation's, not those of the parameter server.

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
        super().__init__(config, lambda first, _: first, namespace)
        self.callback = callback

    def _copy_from_parameter_server(self) -> None:
        self.config.update(self._values)

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
