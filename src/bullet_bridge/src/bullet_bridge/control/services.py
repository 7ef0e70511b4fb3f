"""The services of a controller_manager."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.controllers.base import INTERFACES
from controller_manager_msgs.msg import ControllerState, HardwareInterfaceResources
from controller_manager_msgs.srv import (
    ListControllers,
    ListControllersResponse,
    ListControllerTypes,
    ListControllerTypesResponse,
    LoadController,
    LoadControllerResponse,
    ReloadControllerLibraries,
    ReloadControllerLibrariesResponse,
    SwitchController,
    SwitchControllerRequest,
    SwitchControllerResponse,
    UnloadController,
    UnloadControllerResponse,
)

if TYPE_CHECKING:
    from bullet_sim.controllers.manager import Manager


class ControllerServices:
    """The services NAMESPACE/controller_manager/*.

    Args:
        namespace: of the robot, '' or with a leading slash.
        manager: bullet_sim.controllers.manager.Manager.
        run_job: function that runs a callable in the simulation thread and returns its result, or
            None after it has logged the error.
        load, unload: functions name -> whether it succeeded.
    """

    def __init__(
        self,
        namespace: str,
        manager: "Manager",
        run_job: Callable[[Callable[[], Any]], Any],
        load: Callable[[str], bool],
        unload: Callable[[str], bool],
    ) -> None:
        self._namespace, self._manager, self._run_job = namespace, manager, run_job
        self._do_load, self._do_unload = load, unload
        self._services = []
        try:
            for name, service, handler in (
                ("load_controller", LoadController, self._load),
                ("unload_controller", UnloadController, self._unload),
                ("switch_controller", SwitchController, self._switch),
                ("list_controllers", ListControllers, self._list),
                ("list_controller_types", ListControllerTypes, self._types),
                ("reload_controller_libraries", ReloadControllerLibraries, self._reload),
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

    def _load(self, request: Any) -> LoadControllerResponse:
        return LoadControllerResponse(ok=self._do_load(self._name(request.name)))

    def _unload(self, request: Any) -> UnloadControllerResponse:
        return UnloadControllerResponse(ok=self._do_unload(self._name(request.name)))

    def _switch(self, request: Any) -> SwitchControllerResponse:
        start, stop = (
            [self._name(name) for name in names]
            for names in (request.start_controllers, request.stop_controllers)
        )
        strict = request.strictness != SwitchControllerRequest.BEST_EFFORT
        skipped = self._run_job(lambda: self._manager.switch(start, stop, strict))
        if skipped is None:
            return SwitchControllerResponse(ok=False)
        for reason in skipped:
            rospy.logwarn("%s: %s", self._namespace, reason)
        return SwitchControllerResponse(ok=True)

    def _list(self, _: Any) -> ListControllersResponse:
        response = ListControllersResponse()
        for controller, config, state in self._run_job(self._manager.list) or []:
            claims = config.claims or ((controller.interface, ()),)
            response.controller.append(
                ControllerState(
                    name=config.name,
                    state=state,
                    type=config.type,
                    claimed_resources=[
                        HardwareInterfaceResources(
                            hardware_interface=INTERFACES[interface], resources=list(joints)
                        )
                        for interface, joints in claims
                    ],
                )
            )
        return response

    def _types(self, _: Any) -> ListControllerTypesResponse:
        types = self._manager.types()
        return ListControllerTypesResponse(
            types=types, base_classes=["controller_interface::ControllerBase"] * len(types)
        )

    def _reload(self, request: Any) -> ReloadControllerLibrariesResponse:
        """There are no libraries; as upstream, force_kill stops and unloads all controllers."""
        loaded = self._run_job(self._manager.list)
        if loaded is None:
            return ReloadControllerLibrariesResponse(ok=False)
        if loaded and not request.force_kill:
            rospy.logerr(
                "%s: controllers are loaded (%s); reload_controller_libraries needs "
                "force_kill to unload them",
                self._namespace,
                ", ".join(config.name for _, config, _ in loaded),
            )
            return ReloadControllerLibrariesResponse(ok=False)
        running = [config.name for _, config, state in loaded if state == "running"]
        if running and self._run_job(lambda: self._manager.switch([], running)) is None:
            return ReloadControllerLibrariesResponse(ok=False)
        return ReloadControllerLibrariesResponse(
            ok=all([self._do_unload(config.name) for _, config, _ in loaded])
        )

    def close(self) -> None:
        """Shut down the services."""
        for service in self._services:
            service.shutdown("model deleted")
