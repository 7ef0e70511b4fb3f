"""Assembly of the bridge node."""

import sys
from dataclasses import replace

import rospy
from bullet_sim.errors import SimError
from bullet_sim.formats.xml_read import is_true
from bullet_sim.render.request import Quality
from bullet_sim.system.output import keep_python_output
from bullet_sim.world import World

from bullet_bridge.config import parse_config
from bullet_bridge.loop.arrivals import Arrivals
from bullet_bridge.loop.clock import SimClock, set_own_time
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.loop.server import Server
from bullet_bridge.loop.statistics import StatisticsService
from bullet_bridge.loop.step import StepService
from bullet_bridge.outputs.cameras import Cameras
from bullet_bridge.outputs.viewer_link import ViewerLink
from bullet_bridge.reading import load_world
from bullet_bridge.resolve import Resolver
from bullet_bridge.robots import Robots
from bullet_bridge.services.describe import DescribeService
from bullet_bridge.services.gazebo import GazeboServices
from bullet_bridge.transport import publishing
from bullet_bridge.transport.relay import Relay


def start_relay():
    """The Relay, or None if it does not start."""
    try:
        return Relay()
    except OSError as error:
        rospy.logwarn("the relay does not start: %s; the bridge sends by itself", error)
        return None


def main():
    """Run the node `gazebo`; returns 1 after logging the reason when it cannot start."""
    keep_python_output()
    # A subscription to its own /clock would cost a socket and a thread: SimClock sets the time.
    rospy.init_node("gazebo", disable_rostime=True)
    world = World()
    world.contacts.on_implausible = rospy.logerr
    cameras = viewer = relay = None
    try:
        config = parse_config(lambda name, default: rospy.get_param(f"~{name}", default))
        publishing.set_lockstep(config.lockstep)
        relay = None if config.lockstep else start_relay()
        publishing.set_relay(relay)
        resolve = Resolver()
        described = load_world(world, config.world_file, resolve)
        if config.world_pace and described is not None:
            config = replace(config, real_time_factor=described.real_time_factor)
        jobs = JobQueue()
        rospy.on_shutdown(jobs.close)
        quality = Quality(config.shadows, config.antialias)
        cameras = Cameras(config.renderer, config.lockstep, quality, lambda: world.scene)
        arrivals = Arrivals()
        robots = Robots(jobs, world, cameras, config.seed, arrivals)
        own_time = set_own_time if is_true(rospy.get_param("/use_sim_time", False)) else None
        clock = SimClock(config.clock_rate, world.time_step, own=own_time)
        server = Server(world, jobs, robots, config, clock, relay=relay)
        GazeboServices(world, jobs, robots, server, resolve, config.states_rate, rospy.get_name())
        StatisticsService(jobs, server)
        DescribeService(jobs, world, robots, described)
        StepService(jobs, server, arrivals, config.step_timeout)
        robots.connect_world_models()
        viewer = ViewerLink(jobs, world, server, config.renderer)
        viewer.advertise()
        if config.gui and not config.headless:
            viewer.open()
        rospy.loginfo(
            "world '%s' is up: step %g s, %s",
            world.name,
            world.time_step,
            f"real time x {config.real_time_factor:g}"
            if config.real_time_factor
            else "as fast as possible",
        )
        server.run()
    except (SimError, ValueError) as error:
        rospy.logfatal("%s", error)
        return 1
    finally:
        if viewer is not None:
            viewer.close()
        if cameras is not None:
            cameras.close()
        if relay is not None:
            relay.close()
        world.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
