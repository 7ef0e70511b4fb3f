"""The controller types of controller_manager_tests: they claim joints and command nothing."""

from __future__ import annotations

from typing import Any, ClassVar, Tuple

from bullet_sim.controllers.base import Controller, ControllerConfig, Settings
from bullet_sim.controllers.interfaces import register
from bullet_sim.errors import ControllerError

Claims = Tuple[Tuple[str, Tuple[str, ...]], ...]


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


class Claiming(Controller):
    """Claims what `claims` says.

    Attributes:
        KEYS: parameter -> interface of its joints.
    """

    interface = "effort"
    KEYS: ClassVar[dict[str, str]]

    @classmethod
    def claims(cls, settings: Settings, joints: tuple[str, ...], description: Any) -> Claims:
        return tuple((name, settings.joints(key, joints)) for key, name in cls.KEYS.items())

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: Any
    ) -> ControllerConfig:
        claims = cls.claims(settings, joints, description)
        names = tuple(dict.fromkeys(name for _, names in claims for name in names))
        return ControllerConfig(name=settings.name, joints=names, claims=claims)


class VelEff(Claiming):
    """Claims velocities and efforts."""

    KEYS: ClassVar[dict[str, str]] = {"velocity_joints": "velocity", "effort_joints": "effort"}


class PosEff(Claiming):
    """Claims positions, which the robot does not have, and efforts."""

    KEYS: ClassVar[dict[str, str]] = {"position_joints": "position", "effort_joints": "effort"}


class PosEffOpt(PosEff):
    """As PosEff, without the interfaces that the joints do not have."""

    @classmethod
    def claims(cls, settings: Settings, joints: tuple[str, ...], description: Any) -> Claims:
        offered = register(description.transmissions, description, description.joints).interfaces
        return tuple(
            (interface, names)
            for interface, names in super().claims(settings, joints, description)
            if all(interface in offered.get(name, ()) for name in names)
        )


class MyDummy(Controller):
    """Needs an interface that no robot has."""

    interface = "effort"

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: Any
    ) -> ControllerConfig:
        raise ControllerError(f"{settings.label} needs an interface that the robot does not have")


class Extensible(Claiming):
    """Claims the velocity of one joint."""

    KEYS: ClassVar[dict[str, str]] = {"velocity_joint": "velocity"}

    @classmethod
    def claims(cls, settings: Settings, joints: tuple[str, ...], description: Any) -> Claims:
        return tuple((name, (settings.joint(key, joints),)) for key, name in cls.KEYS.items())


class Derived(Extensible):
    """Claims the effort of another one, too."""

    KEYS: ClassVar[dict[str, str]] = {"velocity_joint": "velocity", "effort_joint": "effort"}
