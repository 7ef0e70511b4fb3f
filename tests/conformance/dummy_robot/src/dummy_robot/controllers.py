"""The controller type of controller_manager_tests: it claims joints and commands nothing."""

from typing import Any

from bullet_sim.controllers.base import Controller, ControllerConfig, Settings


class EffortTest(Controller):
    """Claims the efforts of its `joints`, by default of the first two."""

    interface = "effort"

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: Any
    ) -> ControllerConfig:
        names = ("hiDOF_joint1", "hiDOF_joint2")
        if "joints" in settings:
            names = settings.joints("joints", joints)
        return ControllerConfig(name=settings.name, joints=names, claims=(("effort", names),))
