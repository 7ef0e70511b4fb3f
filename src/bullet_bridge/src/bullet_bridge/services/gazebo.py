"""The services and topics of gazebo_ros below /gazebo."""

from typing import TYPE_CHECKING

from bullet_bridge.plugins.states import PerformanceTopic, StateTopics
from bullet_bridge.services.lights import LightServices
from bullet_bridge.services.links import JointServices, LinkServices
from bullet_bridge.services.models import ModelServices
from bullet_bridge.services.physics import PhysicsProperties, PhysicsServer, PhysicsServices
from bullet_bridge.services.simulation import StateServices

if TYPE_CHECKING:
    from collections.abc import Callable

    from bullet_sim.world import Resolve, World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.loop.server import Server
    from bullet_bridge.robots import Robots


class GazeboServices:
    """Creates all of them.

    Args:
        states_rate: of model_states and link_states [Hz]; 0: one a step.
        prefix: of all names.
        missing_package: see ModelServices.
    """

    def __init__(
        self,
        world: "World",
        jobs: "JobQueue",
        robots: "Robots",
        server: "Server",
        resolve: "Resolve",
        states_rate: float = 0.0,
        prefix: str = "/gazebo",
        missing_package: "Callable[[str], str | None]" = lambda text: None,
    ) -> None:
        server.add_reporter(StateTopics(prefix, world, states_rate))
        server.add_reporter(
            PerformanceTopic(prefix, world, robots.sensor_counts, cameras=robots.camera_names)
        )
        ModelServices(prefix, world, jobs, robots, resolve, server, missing_package)
        LinkServices(prefix, world, jobs, robots.received)
        JointServices(prefix, world, jobs)
        properties = PhysicsProperties(world, server)
        PhysicsServices(prefix, jobs, server, properties)
        PhysicsServer(prefix, jobs, properties)
        StateServices(prefix, jobs, server)
        LightServices(prefix, world, jobs, robots.show_scene)
