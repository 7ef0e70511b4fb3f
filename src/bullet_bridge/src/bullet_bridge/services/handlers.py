"""Handlers of services and topics that log errors and return them to the caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rospy
from bullet_sim.errors import SimError
from std_srvs.srv import EmptyResponse

# Of gazebo_ros' services: for the field of the request, and what it names.
NO_FRAME = "reference {} not found, did you forget to scope the {} by model name?"


class Refusal(SimError):
    """A request is refused with a text of gazebo_ros, which programs compare.

    Args:
        status: for the client.
        detail: what is logged with it.
    """

    def __init__(self, status: str, detail: str) -> None:
        super().__init__(f"{status} ({detail})")
        self.status = status


@contextmanager
def refusing(status: str) -> Iterator[None]:
    """Turns a SimError into a Refusal with a text of gazebo_ros."""
    try:
        yield
    except Refusal:
        raise
    except SimError as error:
        raise Refusal(status, str(error)) from error


def service_handler(work: Callable[[Any], Any], service: Any) -> Callable[[Any], Any]:
    """Handler for a service with `success` and `status_message`.

    Args:
        work: function request -> response.
        service: its class.

    Returns:
        Function request -> response; an error is logged and becomes success=False with the text.
    """

    def handle(request: Any) -> Any:
        try:
            response = work(request)
            response.success = True
            return response
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s", error)
            status = getattr(error, "status", str(error))
            return service._response_class(success=False, status_message=status)

    return handle


def offer(prefix: str, *services: tuple[str, Any, Callable[[Any], Any]]) -> None:
    """Offer services with a service_handler.

    Args:
        services: name, class and work of each.
    """
    for name, service, work in services:
        rospy.Service(f"{prefix}/{name}", service, service_handler(work, service))


def empty_service_handler(
    work: Callable[[Any], Any], response: type = EmptyResponse
) -> Callable[[Any], Any]:
    """Handler for a service with an empty response: an error is a failed call."""

    def handle(request: Any) -> Any:
        try:
            work(request)
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s", error)
            raise rospy.ServiceException(str(error)) from error
        return response()

    return handle


def topic_callback(work: Callable[[Any], Any]) -> Callable[[Any], None]:
    """Callback of a topic: an error is logged, at most once a second."""

    def handle(message: Any) -> None:
        try:
            work(message)
        except (SimError, TimeoutError) as error:
            rospy.logerr_throttle(1.0, str(error))

    return handle
