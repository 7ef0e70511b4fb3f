"""One observer of a running world, a process of its own; bench.py starts it.

observe.py drive T0        first picture and controllers since T0 (time.monotonic), then a window
                           of driving with the camera on
observe.py clock           receipt times of /clock in a window
observe.py free S ROUNDS   as fast as possible: S seconds of the bridge and S of the bare core, in
                           turn

Windows come on stdin as "BEGIN END" (time.monotonic); answers are JSON, one line each.
"""

import json
import os
import socket
import struct
import sys
import time
from urllib.parse import urlparse

import rospkg
import rospy
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import GetModelState, GetWorldProperties
from std_msgs.msg import Float64
from std_srvs.srv import Empty

from bullet_bridge.resolve import Resolver
from bullet_sim.pose import Pose
from bullet_sim.sdf import parse_world
from bullet_sim.world import World

WHEELS = [f'{side}_{end}_wheel' for side in ('left', 'right') for end in ('rear', 'front')]
HINGES = [f'{side}_steering_hinge' for side in ('left', 'right')]
SPEED, ANGLE = 20.0, 0.25       # wheel speed [rad/s], hinge angle [rad]: a circle
COMMANDS = ([(f'{name}_velocity_controller', SPEED) for name in WHEELS]
            + [(f'{name}_position_controller', ANGLE) for name in HINGES])
CONTROLLERS = 7
START_LIMIT = 120.0             # [s]


def say(**values):
    """Answer bench.py."""
    print(json.dumps(values), flush=True)


def pause_until(moment):
    """Sleep until a time of time.monotonic."""
    time.sleep(max(0.0, moment - time.monotonic()))


def join_graph():
    """Become a node, without a subscription to /clock of its own."""
    address = urlparse(os.environ['ROS_MASTER_URI'])
    limit = time.monotonic() + START_LIMIT
    while True:
        try:
            socket.create_connection((address.hostname, address.port), 1).close()
            break
        except OSError:
            if time.monotonic() > limit:
                sys.exit('observe: no master')
            time.sleep(0.02)
    rospy.init_node('bench', anonymous=True, disable_rostime=True, disable_rosout=True,
                    disable_signals=True)


def record(topic, offset):
    """Subscribe; returns the list that gets (receipt [s], stamp [s]).

    Args:
        offset: of the stamp in the serialised message [bytes].
    """
    found = []

    def take(message):
        now = time.monotonic()
        seconds, nanoseconds = struct.unpack_from('<II', message._buff, offset)
        found.append((now, seconds + nanoseconds * 1e-9))
    rospy.Subscriber(topic, rospy.AnyMsg, take, buff_size=1 << 22, tcp_nodelay=True)
    return found


def running_controllers():
    """How many controllers run; 0 while the manager is not there."""
    try:
        listed = rospy.ServiceProxy('/racecar/controller_manager/list_controllers',
                                    ListControllers)()
    except (rospy.ServiceException, rospy.ROSException):
        return 0
    return sum(controller.state == 'running' for controller in listed.controller)


def wait_for_controllers():
    """Returns when all controllers run, as time.monotonic."""
    limit = time.monotonic() + START_LIMIT
    while running_controllers() < CONTROLLERS:
        if time.monotonic() > limit:
            sys.exit(f'observe: {running_controllers()} of {CONTROLLERS} controllers run')
        time.sleep(0.03)
    return time.monotonic()


def publishers():
    """[(publisher, value)] of the circle."""
    return [(rospy.Publisher(f'/racecar/{name}/command', Float64, queue_size=1), value)
            for name, value in COMMANDS]


def car_speed():
    """Speed of the car over the ground [m/s]."""
    state = rospy.ServiceProxy('/gazebo/get_model_state', GetModelState)('racecar', '')
    return (state.twist.linear.x ** 2 + state.twist.linear.y ** 2) ** 0.5


def drive(began):
    """Time the start, then drive while a window of pictures is recorded."""
    join_graph()
    pictures = record('/camera/image', 4)
    controllers = wait_for_controllers() - began
    limit = time.monotonic() + START_LIMIT
    while not pictures:
        if time.monotonic() > limit:
            sys.exit('observe: no picture')
        time.sleep(0.01)
    outputs = publishers()
    say(first_image=pictures[0][0] - began, controllers=controllers)
    line = sys.stdin.readline()
    if not line.strip():
        return
    begin, end = map(float, line.split())
    speed = 0.0
    while time.monotonic() < end:
        for publisher, value in outputs:
            publisher.publish(value)
        if not speed and time.monotonic() > (begin + end) / 2:
            speed = car_speed()
        time.sleep(1 / 30)
    say(pictures=[pair for pair in pictures if begin <= pair[0] < end], speed=speed)


def clock():
    """Record /clock in the window."""
    join_graph()
    ticks = record('/clock', 0)
    begin, end = map(float, sys.stdin.readline().split())
    pause_until(end)
    say(ticks=[pair for pair in ticks if begin <= pair[0] < end])


def bare_world():
    """The core with the world, track, car, controllers and commands of the running bridge."""
    resolve = Resolver()
    path = rospkg.RosPack().get_path('track_model') + '/worlds/track.world'
    world = World()
    with open(path, 'rb') as file:
        world.load(parse_world(file.read(), resolve, path))
    world.spawn_sdf('track', rospy.get_param('/track_description'), Pose(), resolve)
    car = world.spawn_urdf('racecar', rospy.get_param('/robot_description'), Pose(), resolve)
    for name, _ in COMMANDS:
        car.manager.load(name, rospy.get_param(f'/racecar/{name}'))
    car.manager.switch([name for name, _ in COMMANDS], [])
    for name, value in COMMANDS:
        car.manager.command(name, [value])
    return world


def bare_speed(world):
    """Speed of the bare core's car over the ground [m/s]."""
    car = world.model('racecar')
    linear = car.link_state(car.description.root)[1]
    return float((linear[0] ** 2 + linear[1] ** 2) ** 0.5)


def step_for(world, seconds):
    """Step as fast as possible; returns simulated seconds per wall second."""
    sim, begin = world.time, time.monotonic()
    while time.monotonic() - begin < seconds:
        for _ in range(50):
            world.step()
    return (world.time - sim) / (time.monotonic() - begin)


def free(seconds, rounds):
    """Alternate the bridge (bare core idle) and the bare core (bridge paused)."""
    join_graph()
    wait_for_controllers()
    properties = rospy.ServiceProxy('/gazebo/get_world_properties', GetWorldProperties)
    pause = rospy.ServiceProxy('/gazebo/pause_physics', Empty)
    unpause = rospy.ServiceProxy('/gazebo/unpause_physics', Empty)
    outputs = publishers()
    time.sleep(0.5)
    for publisher, value in outputs:
        publisher.publish(value)
    time.sleep(0.5)
    pause()
    world = bare_world()
    step_for(world, 0.5)
    say(step=world.time_step)
    for _ in range(rounds):
        unpause()
        sys.stdin.readline()    # bench.py reads the processor time
        sim, begin = properties().sim_time, time.monotonic()
        time.sleep(seconds)
        after, end = properties().sim_time, time.monotonic()
        say(bridge=(after - sim) / (end - begin), sim=after - sim, speed=car_speed())
        sys.stdin.readline()
        pause()
        say(bare=step_for(world, seconds), speed=bare_speed(world))
    world.close()
    unpause()       # a paused bridge may not notice the end


def main():
    """See the module's docstring."""
    kind, *rest = sys.argv[1:]
    if kind == 'drive':
        drive(float(rest[0]))
    elif kind == 'clock':
        clock()
    else:
        free(float(rest[0]), int(rest[1]))
    sys.stdout.flush()
    os._exit(0)     # without rospy's farewell to a master that may be gone


if __name__ == '__main__':
    main()
