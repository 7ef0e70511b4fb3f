"""Plugins of models in C++, loaded by Gazebo's own libraries."""

from __future__ import annotations

from typing import ClassVar

import rospy
from bullet_sim.errors import SimError
from bullet_sim.plugins.cpp import CppSpec

from bullet_bridge.gazebo_host.host import host_of
from bullet_bridge.plugins.base import Preparing, ros_side


@ros_side(CppSpec)
class CppPlugin(Preparing):
    """A plugin's library, which acts from when its model is there until that is deleted."""

    CACHE: ClassVar[tuple[str, ...]] = ("_is_loaded", "_was_tried")
    _is_loaded = _was_tried = False

    def prepare(self) -> None:
        """Load it, once (simulation thread); an error is logged, as in Gazebo the model stays."""
        if self._was_tried:
            return
        self._was_tried = True
        try:
            host_of(self.world).load(self.spec, self.model)
        except SimError as error:
            rospy.logerr("model '%s': %s", self.model.name, error)
        else:
            self._is_loaded = True

    def reset(self, time: float) -> None:
        super().reset(time)
        if self._is_loaded:
            host_of(self.world).reset(time)
