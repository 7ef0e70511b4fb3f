"""controller_manager_msgs.utils: filters, and finding managers by their services."""

import pytest
from controller_manager_msgs import utils
from controller_manager_msgs.msg import ControllerState, HardwareInterfaceResources


def controller(name, state, *claims):
    claimed = [HardwareInterfaceResources(interface, resources) for interface, resources in claims]
    return ControllerState(
        name=name, state=state, type=f"{name}_base/Type", claimed_resources=claimed
    )


WHEELS = controller("wheels", "running", ("VelocityInterface", ["left", "right"]))
ARM = controller("arm", "stopped", ("EffortInterface", ["a"]), ("PositionInterface", ["a", "b"]))
ALL = [WHEELS, ARM]


@pytest.mark.parametrize(
    "found, expected",
    [
        (utils.filter_by_name(ALL, "wheels"), [WHEELS]),
        (utils.filter_by_name(ALL, "wheel"), []),
        (utils.filter_by_name(ALL, "wheel", match_substring=True), [WHEELS]),
        (utils.filter_by_type(ALL, "arm_base/Type"), [ARM]),
        (utils.filter_by_state(ALL, "running"), [WHEELS]),
        (utils.filter_by_hardware_interface(ALL, "EffortInterface"), [ARM]),
        (utils.filter_by_hardware_interface(ALL, "Interface", match_substring=True), ALL),
        (utils.filter_by_resources(ALL, ["a", "b"]), [ARM]),
        (utils.filter_by_resources(ALL, ["a", "b"], "EffortInterface"), []),
        (utils.filter_by_resources(ALL, ["b", "right"], match_any=True), ALL),
        (utils.filter_by_resources(ALL, ["b", "right"]), []),
    ],
)
def test_filters(found, expected):
    assert found == expected


@pytest.fixture(name="services")
def _services(monkeypatch):
    services = {}
    for namespace in ("", "/car"):
        for name, kind in utils.cm_services.items():
            services[f"{namespace}/controller_manager/{name}"] = kind
    services["/odd/list_controllers"] = "std_srvs/Empty"
    monkeypatch.setattr(utils.rosservice, "get_service_list", lambda **_: sorted(services))
    monkeypatch.setattr(utils.rosservice, "get_service_type", services.get)
    return services


def test_managers_are_found_by_all_of_their_services(services):
    found = ["/car/controller_manager", "/controller_manager"]
    assert utils.get_controller_managers() == found
    lister = utils.ControllerManagerLister()
    assert lister() == found
    del services["/car/controller_manager/load_controller"]
    assert lister() == found  # as known from the first call
    assert utils.get_controller_managers() == ["/controller_manager"]
    assert not utils.is_controller_manager("/car/controller_manager")


def test_names_of_controllers_on_the_parameter_server(monkeypatch):
    names = ["/foo/type", "/xxx/type/xxx", "/ns/bar/type", "/ns/yyy/type/yyy", "/type"]
    monkeypatch.setattr(utils.rospy, "get_param_names", lambda: names)
    assert utils.get_rosparam_controller_names() == ["foo"]
    assert utils.get_rosparam_controller_names("/ns") == ["bar"]
