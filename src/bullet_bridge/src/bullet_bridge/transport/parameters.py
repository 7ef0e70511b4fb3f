"""Parameters as roscpp finds them."""

from __future__ import annotations

from typing import Any

import rosgraph


def nearest(namespace: str, name: str) -> Any:
    """Value of the parameter of a name that is nearest to a namespace, in it or above.

    Raises:
        OSError: there is no master.
        rosgraph.MasterException: there is no such parameter.
    """
    namespace = namespace.strip("/")
    master = rosgraph.Master(f"/{namespace}")
    # A Master called "/" has an empty name, from which the master refuses to search.
    found = master.searchParam(name) if namespace else rosgraph.names.ns_join("/", name)
    return master.getParam(found)
