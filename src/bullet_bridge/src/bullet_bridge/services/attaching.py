"""The services of the world plugin libgazebo_ros_link_attacher.so: models that hold each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import genpy
import genpy.dynamic
import rospy
from bullet_sim.errors import SimError

if TYPE_CHECKING:
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue

PREFIX = "/link_attacher_node"
FIELDS = ("model_name_1", "link_name_1", "model_name_2", "link_name_2")
MD5_SUM = "c91fb3be70ce66d19130d40294cf4bd5"


class LinkAttacher:
    """Attaches links, and lets them go.

    As upstream a pair that is attached for a second time comes back to where its links were to each
    other at the first; what was let go before is let go with success; names are not resolved.
    """

    def __init__(self, world: World, jobs: JobQueue) -> None:
        self._world, self._jobs = world, jobs
        service = attach_type()
        rospy.Service(f"{PREFIX}/attach", service, self._attach)
        rospy.Service(f"{PREFIX}/detach", service, self._detach)

    def _attach(self, request: Any) -> Any:
        names = [getattr(request, field) for field in FIELDS]

        def work() -> None:
            if not self._world.engine.attach_again(_key(names)):
                self._world.attach(_key(names), *names)

        try:
            self._jobs.call(work)
        except (SimError, TimeoutError) as error:
            rospy.logerr("Could not make the attach: %s", error)
            return {"ok": False}
        rospy.loginfo("%s::%s and %s::%s are attached", *names)
        return {"ok": True}

    def _detach(self, request: Any) -> Any:
        names = [getattr(request, field) for field in FIELDS]
        done = self._jobs.call(lambda: self._world.engine.detach(_key(names)))
        if not done:
            rospy.logerr("Could not make the detach: %s::%s and %s::%s were not attached", *names)
        return {"ok": done}


def _key(names: list[str]) -> tuple[str, ...]:
    return ("link_attacher", *names)


def attach_type() -> Any:
    """gazebo_ros_link_attacher/Attach: of that package, or made here where it is not built."""
    try:
        from gazebo_ros_link_attacher.srv import Attach
    except ImportError:
        return _made_type()
    return Attach


def _made_type() -> Any:
    kind = "gazebo_ros_link_attacher/Attach"
    request = genpy.dynamic.generate_dynamic(
        f"{kind}Request", "".join(f"string {field}\n" for field in FIELDS)
    )[f"{kind}Request"]
    response = genpy.dynamic.generate_dynamic(f"{kind}Response", "bool ok\n")[f"{kind}Response"]
    values = {
        "_type": kind,
        "_md5sum": MD5_SUM,
        "_request_class": request,
        "_response_class": response,
    }
    return type("Attach", (), values)
