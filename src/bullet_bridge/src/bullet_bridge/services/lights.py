"""Services about lights: read, change and delete those of the world."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from bullet_sim.description.model import RGB, Light
from bullet_sim.errors import WorldError
from bullet_sim.pose import PLACEABLE, Pose
from gazebo_msgs import srv
from std_msgs.msg import ColorRGBA

from bullet_bridge.services.handlers import offer, refusing

if TYPE_CHECKING:
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue

LEVEL = (0.0, 0.0, 0.0, 1.0)


class LightServices:
    """Services about the lights of a world's Scene.

    Args:
        show: function without arguments, called after a change (simulation thread).
    """

    def __init__(self, prefix: str, world: World, jobs: JobQueue, show: Callable[[], None]) -> None:
        self._world, self._jobs, self._show = world, jobs, show
        offer(
            prefix,
            ("get_light_properties", srv.GetLightProperties, self._get),
            ("set_light_properties", srv.SetLightProperties, self._set),
            ("delete_light", srv.DeleteLight, self._delete),
        )

    def _light(self, name: str) -> Light:
        lights = self._world.scene.lights
        light = next((light for light in lights if light.name == name), None)
        if light is None:
            names = ", ".join(light.name for light in lights) or "(none)"
            raise WorldError(f"light '{name}' does not exist; lights are {names}")
        return light

    def _get(self, request: Any) -> srv.GetLightPropertiesResponse:
        with _refusing_unknown("getLightProperties", request):
            light = self._jobs.read(lambda: self._light(request.light_name))
        return srv.GetLightPropertiesResponse(
            diffuse=ColorRGBA(*light.diffuse, 1.0),
            attenuation_constant=light.constant,
            attenuation_linear=light.linear,
            attenuation_quadratic=light.quadratic,
        )

    def _set(self, request: Any) -> srv.SetLightPropertiesResponse:
        def work() -> None:
            with _refusing_unknown("setLightProperties", request):
                self._light(request.light_name)
            self._change(request.light_name, lambda old: changed(old, request))

        self._jobs.call(work)
        return srv.SetLightPropertiesResponse()

    def _delete(self, request: Any) -> srv.DeleteLightResponse:
        # what gazebo_ros answers also for a light that is not there
        with refusing(f'DeleteLight: Timeout reached while removing light "{request.light_name}"'):
            self._jobs.call(lambda: self._change(request.light_name, lambda _: None))
        status = f"DeleteLight: {request.light_name} successfully deleted"
        return srv.DeleteLightResponse(status_message=status)

    def _change(self, name: str, change: Callable[[Light], Light | None]) -> None:
        """Replace a light by what `change` makes of it; None: delete it."""
        light = self._light(name)
        new = change(light)
        scene = self._world.scene
        lights = [new if other is light else other for other in scene.lights]
        self._world.scene = replace(
            scene, lights=tuple(other for other in lights if other is not None)
        )
        self._show()


def _refusing_unknown(service: str, request: Any) -> AbstractContextManager[None]:
    """Refuses a light that does not exist, as gazebo_ros words it."""
    return refusing(f"{service}: Requested light {request.light_name} not found!")


def changed(light: Light, request: Any) -> Light:
    """A Light as a SetLightProperties request specifies it.

    A direction of length zero leaves it unchanged, an orientation of length zero counts as none.

    Raises:
        WorldError: a number is not finite, negative where it must not be, or out of bounds.
    """
    position, rotation, vector = request.pose.position, request.pose.orientation, request.direction
    given = (rotation.x, rotation.y, rotation.z, rotation.w)
    pose = Pose((position.x, position.y, position.z), given if any(given) else LEVEL)
    if not pose.is_placeable():
        raise WorldError(f"pose of light '{light.name}' is {pose.position}, {given}; {PLACEABLE}")
    direction = np.array((vector.x, vector.y, vector.z))
    length = float(np.linalg.norm(direction))
    if not math.isfinite(length):
        raise WorldError(f"direction of light '{light.name}' is {tuple(direction)}, must be finite")
    if length > 1e-9:
        direction = pose.normalized().matrix @ (direction / length)
    x, y, z = direction.tolist()
    constant, linear, quadratic = (
        _not_negative(getattr(request, f"attenuation_{name}"), f"{name} attenuation", light)
        for name in ("constant", "linear", "quadratic")
    )
    return replace(
        light,
        position=pose.position,
        direction=(x, y, z) if length > 1e-9 else light.direction,
        diffuse=_color(request.diffuse, f"diffuse of light '{light.name}'"),
        specular=_color(request.specular, f"specular of light '{light.name}'"),
        constant=constant,
        linear=linear,
        quadratic=quadratic,
        cast_shadows=bool(request.cast_shadows),
    )


def _color(color: Any, label: str) -> RGB:
    values = (color.r, color.g, color.b)
    if not all(math.isfinite(value) and value >= 0.0 for value in values):
        raise WorldError(f"{label} is {values}, must be finite and 0 or more")
    red, green, blue = (min(1.0, value) for value in values)
    return red, green, blue


def _not_negative(value: float, name: str, light: Light) -> float:
    if not (math.isfinite(value) and value >= 0.0):
        raise WorldError(f"{name} of light '{light.name}' is {value}, must be finite and 0 or more")
    return float(value)
