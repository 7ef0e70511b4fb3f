"""Handlers of services and topics when something is wrong."""

import pytest
import rospy
from bullet_bridge.services import handlers
from bullet_sim.errors import WorldError
from gazebo_msgs.srv import DeleteModel, DeleteModelResponse
from std_srvs.srv import EmptyResponse


@pytest.fixture(name="log")
def _log(monkeypatch):
    lines = []
    monkeypatch.setattr(handlers.rospy, "logerr", lambda text, *rest: lines.append(text % rest))
    monkeypatch.setattr(handlers.rospy, "logerr_throttle", lambda _, text: lines.append(text))
    return lines


def fail(error):
    """Work that fails."""

    def work(_request):
        raise error

    return work


def test_a_response_with_success(log):
    handle = handlers.service_handler(
        lambda _: DeleteModelResponse(status_message="gone"), DeleteModel
    )
    response = handle(None)
    assert (response.success, response.status_message, log) == (True, "gone", [])


@pytest.mark.parametrize("error", [WorldError("no 100 % match"), TimeoutError("too late")])
def test_errors_are_returned_and_logged_once(log, error):
    response = handlers.service_handler(fail(error), DeleteModel)(None)
    assert (response.success, response.status_message) == (False, str(error))
    assert log == [str(error)]


def test_a_response_without_fields_is_a_failed_call(log):
    assert handlers.empty_service_handler(lambda _: None)(None) == EmptyResponse()
    with pytest.raises(rospy.ServiceException, match="no such thing"):
        handlers.empty_service_handler(fail(WorldError("no such thing")))(None)
    assert log == ["no such thing"]


def test_a_message_that_is_wrong_goes_to_the_log(log):
    handlers.topic_callback(fail(WorldError("no such model")))(None)
    assert log == ["no such model"]


def test_errors_of_the_program_are_not_hidden(log):
    for wrap in (
        lambda work: handlers.service_handler(work, DeleteModel),
        handlers.empty_service_handler,
        handlers.topic_callback,
    ):
        with pytest.raises(ZeroDivisionError):
            wrap(fail(ZeroDivisionError()))(None)
    assert log == []
