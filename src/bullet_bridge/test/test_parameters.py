"""Parameters looked for from a namespace upwards, by the code of rosmaster and rosgraph."""

import pytest
import rosgraph
from bullet_bridge.transport.parameters import nearest
from rosmaster.paramserver import ParamDictionary


@pytest.fixture(autouse=True)
def known(monkeypatch):
    """Parameters of a master without its server."""
    parameters = ParamDictionary(None)

    class Master(rosgraph.Master):
        def _reinit(self, master_uri):
            """No connection."""

        def searchParam(self, key):  # noqa: N802
            try:
                found = parameters.search_param(self.caller_id, key)
            except ValueError as error:
                raise rosgraph.MasterFailure(str(error)) from error
            if found is None:
                raise rosgraph.MasterError("there is none")
            return found

        def getParam(self, key):  # noqa: N802
            try:
                return parameters.get_param(key)
            except KeyError as error:
                raise rosgraph.MasterError("there is none") from error

    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
    monkeypatch.setattr(rosgraph, "Master", Master)
    parameters.set_param("/robot_description", "root")
    parameters.set_param("/a/robot_description", "of a")


@pytest.mark.parametrize("namespace, value", [
    ("", "root"), ("/", "root"), ("/b", "root"), ("a", "of a"), ("/a/b/", "of a"),
])  # fmt: skip
@pytest.mark.parametrize("name", ["robot_description", "/robot_description"])
def test_the_nearest(namespace, value, name):
    assert nearest(namespace, name) == ("root" if name.startswith("/") else value)


@pytest.mark.parametrize("namespace", ["/", "/a"])
def test_there_is_none(namespace):
    with pytest.raises(rosgraph.MasterException):
        nearest(namespace, "no_such_parameter")
