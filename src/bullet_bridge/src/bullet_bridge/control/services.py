"""The services of a controller_manager."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.controllers import CONTROLLERS
from bullet_sim.controllers.interfaces import INTERFACES
from controller_manager_msgs import srv
from controller_manager_msgs.msg import ControllerState, HardwareInterfaceResources

if TYPE_CHECKING:
    from bullet_sim.controllers.manager import Manager


class ControllerServices:
    """The services NAMESPACE/controller_manager/*.

    Args:
        namespace: of the robot, '' or with a leading slash.
        run_job: function that runs a callable in the simulation thread and returns its result, or
            None after it has logged the error.
        load, unload: functions name -> whether it succeeded.
    """

    def __init__(
        self,
        namespace: str,
        manager: Manager,
        run_job: Callable[[Callable[[], Any]], Any],
        load: Callable[[str], bool],
        unload: Callable[[str], bool],
    ) -> None:
        self._namespace, self._manager, self._run_job = namespace, manager, run_job
        self._do_load, self._do_unload = load, unload
        self._services = []
        try:
            for name, service, handler in (
                ("load_controller", srv.LoadController, self._load),
                ("unload_controller", srv.UnloadController, self._unload),
                ("switch_controller", srv.SwitchController, self._switch),
                ("list_controllers", srv.ListControllers, self._list),
                ("list_controller_types", srv.ListControllerTypes, self._types),
                ("reload_controller_libraries", srv.ReloadControllerLibraries, self._reload),
            ):
                self._services.append(
                    rospy.Service(f"{namespace}/controller_manager/{name}", service, handler)
                )
        except BaseException:
            self.close()
            raise

    def _name(self, text: str) -> str:
        """A controller's name, without slashes and the robot's namespace."""
        prefix = self._namespace.strip("/") + "/"
        text = text.strip("/")
        return text[len(prefix) :] if len(prefix) > 1 and text.startswith(prefix) else text

    def _load(self, request: Any) -> srv.LoadControllerResponse:
        return srv.LoadControllerResponse(ok=self._do_load(self._name(request.name)))

    def _unload(self, request: Any) -> srv.UnloadControllerResponse:
        return srv.UnloadControllerResponse(ok=self._do_unload(self._name(request.name)))

    def _switch(self, request: Any) -> srv.SwitchControllerResponse:
        start, stop = (
            [self._name(name) for name in names]
            for names in (request.start_controllers, request.stop_controllers)
        )
        strict = request.strictness == srv.SwitchControllerRequest.STRICT
        if request.strictness == 0:
            rospy.logwarn(
                "Controller Manager: To switch controllers you need to specify a strictness level "
                "of controller_manager_msgs::SwitchController::STRICT (%d) or ::BEST_EFFORT (%d). "
                "Defaulting to ::BEST_EFFORT.",
                srv.SwitchControllerRequest.STRICT,
                srv.SwitchControllerRequest.BEST_EFFORT,
            )
        skipped = self._run_job(lambda: self._manager.switch(start, stop, strict))
        if skipped is None:
            return srv.SwitchControllerResponse(ok=False)
        for reason in skipped:
            rospy.logwarn("%s: %s", self._namespace or "/", reason)
        return srv.SwitchControllerResponse(ok=True)

    def _list(self, _: Any) -> srv.ListControllersResponse:
        response = srv.ListControllersResponse()
        for controller, config, state in self._run_job(self._manager.list) or []:
            claims = config.claims or ((controller.interface, ()),)
            response.controller.append(
                ControllerState(
                    name=config.name,
                    state=state,
                    type=config.type,
                    claimed_resources=[
                        HardwareInterfaceResources(
                            hardware_interface=INTERFACES[interface], resources=sorted(joints)
                        )
                        for interface, joints in claims
                    ],
                )
            )
        return response

    def _types(self, _: Any) -> srv.ListControllerTypesResponse:
        types = sorted(CONTROLLERS.names())
        return srv.ListControllerTypesResponse(
            types=types, base_classes=["controller_interface::ControllerBase"] * len(types)
        )

    def _reload(self, request: Any) -> srv.ReloadControllerLibrariesResponse:
        """There are no libraries; as upstream, force_kill stops and unloads all controllers."""
        loaded = self._run_job(self._manager.list)
        if loaded is None:
            return srv.ReloadControllerLibrariesResponse(ok=False)
        if loaded and not request.force_kill:
            rospy.logerr(
                "Controller manager: Cannot reload controller libraries because there are still "
                "%i controllers running",
                len(loaded),
            )
            return srv.ReloadControllerLibrariesResponse(ok=False)
        if loaded:
            rospy.loginfo("Controller manager: Killing all running controllers")
        running = [config.name for _, config, state in loaded if state == "running"]
        if running and self._run_job(lambda: self._manager.switch([], running)) is None:
            return srv.ReloadControllerLibrariesResponse(ok=False)
        return srv.ReloadControllerLibrariesResponse(
            ok=all([self._do_unload(config.name) for _, config, _ in loaded])
        )

    def close(self) -> None:
        for service in self._services:
            service.shutdown("model deleted")
