"""Is Paddock/Robot-v0 of a launch file what the launch file is over ROS?

    ./run exec python bench/environment_beside_launch.py my_robot my_robot.launch gui:=false

It starts the launch file on a master of its own, in lockstep, and drives the same commands at the
same steps in both: random ones, then a constant one. Every message of a topic that the environment
observes is compared, bit by bit, and the robots' poses. Then it drives the environment alone, as
many random actions as --alone says. It exits 1 where something differs or nothing moves, and says
which observations never change, as a scan of an empty world. Other nodes of the launch file run
over ROS alone: what they do to the simulation is a difference.
"""

import argparse
import contextlib
import math
import os
import shlex
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import warnings

import numpy as np

LIMIT = 180.0  # wall time until the graph is up, and for a message [s]
LATE = 5.0  # wall time for a message that a step has sent already [s]
STARTS = 30.0  # longest wall time for other nodes of the launch file to join the graph [s]
QUIET = 1.0  # wall time without a change of the graph after which they all have joined [s]
PERIOD = 0.1  # of an action [s]
CONSTANT = 30  # actions with the constant command
MOVES = 1e-3  # least way [m] or change of a joint [rad, m] under the constant command
LOCKSTEP = '<launch><param name="{}/lockstep" type="bool" value="true"/></launch>'


def parted(launch):
    """Path of a launch file and its arguments, of words as for roslaunch."""
    from roslaunch.rlutil import resolve_launch_arguments

    words = shlex.split(launch)
    [path] = resolve_launch_arguments([word for word in words if ":=" not in word])
    return path, [word for word in words if ":=" in word]


class Graph:
    """A launch file that has been started on a master of its own, in lockstep.

    Args:
        launch: as for roslaunch.
        simulator: resolved name of its node.
    """

    def __init__(self, launch, simulator):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        for name in ("DISPLAY", "WAYLAND_DISPLAY", "ROS_HOSTNAME"):
            os.environ.pop(name, None)
        os.environ.update(ROS_IP="127.0.0.1", ROS_MASTER_URI=f"http://127.0.0.1:{port}")
        os.environ["QT_QPA_PLATFORM"] = "offscreen"
        self._folder = tempfile.TemporaryDirectory()
        lockstep = os.path.join(self._folder.name, "lockstep.launch")
        with open(lockstep, "w", encoding="utf-8") as file:
            file.write(LOCKSTEP.format(simulator))
        path, arguments = parted(launch)
        command = ["roslaunch", "-p", str(port), path, lockstep, *arguments]
        self.log = os.path.join(self._folder.name, "log")
        with open(self.log, "w", encoding="utf-8") as log:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                start_new_session=True,
            )  # fmt: skip

    def wait(self, condition, what, limit=LIMIT):
        """Wait until a function without arguments returns something true, and return it.

        Raises:
            SystemExit: it takes too long, or roslaunch has ended.
        """
        end = time.monotonic() + limit
        while time.monotonic() < end and self._process.poll() is None:
            with contextlib.suppress(OSError):
                if value := condition():
                    return value
            time.sleep(0.02)
        with open(self.log, encoding="utf-8") as log:
            print("".join(log.readlines()[-30:]), file=sys.stderr)
        ended = (
            "roslaunch has ended" if self._process.poll() is not None else f"not within {limit:g} s"
        )
        raise SystemExit(f"{what}: {ended}")

    def close(self):
        """End roslaunch and its nodes."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGINT)
            try:
                self._process.wait(60.0)
            except subprocess.TimeoutExpired:
                os.killpg(self._process.pid, signal.SIGKILL)
        self._folder.cleanup()


class Topic:
    """A topic that both have: the graph's messages beside the environment's arrays.

    Attributes:
        compared: messages.
        differs: what the first one that differed had; empty: none did.
        changes: whether its observation has changed.
    """

    def __init__(self, name, source, env):
        import rospy
        from paddock_gym.driver.robot import Source
        from roslib.message import get_message_class

        self.name, self._env, self._source = name, env, Source(**source)
        self._messages, self._lock = [], threading.Lock()
        self.compared, self.differs, self.changes = 0, "", False
        self._first, self._stamp = self._observation(), env.stamp(name)
        kind = get_message_class(source["message"])
        rospy.Subscriber(name, kind, self._keep, queue_size=None, buff_size=2**24)

    def _keep(self, message):
        with self._lock:
            self._messages = [*self._messages[-9:], message]

    def _observation(self):
        return self._env.agent.observed[self.name].read()

    def _message(self, stamp):
        """The graph's message of a time [s]; of a type without header: the last one; or None."""
        with self._lock:
            messages = list(self._messages)
        if messages and not hasattr(messages[-1], "header"):
            return messages[-1]
        near = (m for m in messages if abs(m.header.stamp.to_sec() - stamp) < 1e-6)
        return next(near, None)

    def compare(self, graph):
        """Compare the last messages, if the environment has a new one."""
        stamp, seen = self._env.stamp(self.name), self._observation()
        self.changes |= not np.array_equal(seen, self._first, equal_nan=True)
        if math.isnan(stamp) or stamp == self._stamp or self.differs:
            return
        self._stamp, end, got = stamp, time.monotonic() + LATE, None
        while time.monotonic() < end:
            message = self._message(stamp)
            if message is not None:
                self._source.take(message)
                got = self._source.read()
                if np.array_equal(got, seen, equal_nan=True):
                    self.compared += 1
                    return
                if hasattr(message, "header"):
                    break
            time.sleep(0.002)
        self.differs = f"at {stamp:.3f} s: {self._difference(got, seen)}"

    def _difference(self, got, seen):
        if got is None:
            with self._lock:
                stamps = [f"{m.header.stamp.to_sec():.3f}" for m in self._messages[-3:]]
            return f"no message over ROS of that time; its last ones are of {stamps}"
        if got.shape != seen.shape:
            return f"{got.shape} over ROS, {seen.shape} in the environment"
        wrong = ~((got == seen) | ((got != got) & (seen != seen)))
        place = tuple(int(index[0]) for index in np.nonzero(wrong))
        return (
            f"{int(wrong.sum())} of {wrong.size} numbers, first {place}: {got[place]!r} over ROS, "
            f"{seen[place]!r} in the environment"
        )


def all_topics(world):
    """Names of what a RobotWorld sends that has a fixed size."""
    return tuple(name for name, topic in world.topics.items() if topic.output.shapes())


def make(launch, action):
    """RobotEnv of a launch file that observes all of its topics."""
    from paddock_gym.envs.robot import RobotEnv
    from paddock_gym.errors import GymError
    from paddock_gym.simulation.launch_file import from_launch
    from paddock_gym.simulation.robot_world import RobotWorld

    recipe = from_launch(launch)
    world = RobotWorld(recipe)
    observation, commands = all_topics(world), tuple(world.commands)
    for text in world.warnings:
        print(f"  warning: {text}")
    world.close()
    options = {"observation": observation, "settle": 0.0, "vary": ()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return RobotEnv(recipe, action=action or None, **options)
        except GymError as error:
            if action or "has to be given" not in str(error):
                raise
            print(f"  {error}; all of {', '.join(commands)} are")
            return RobotEnv(recipe, action=commands, **options)


def simulator_of(launch):
    """Resolved name of the node that the simulator is, in a launch file."""
    import roslaunch.config
    from paddock_gym.simulation.launch_file import SIMULATORS

    path, arguments = parted(launch)
    config = roslaunch.config.load_config_default([(path, arguments)], None, verbose=False)
    found = [n for n in config.nodes if (n.package, n.type) in SIMULATORS]
    return found[0].namespace.rstrip("/") + "/" + found[0].name if found else "/gazebo"


def wait_up(graph, env):
    """Wait until models and controllers are there that the environment has."""
    import rospy
    from controller_manager_msgs.srv import ListControllers
    from gazebo_msgs.srv import GetWorldProperties

    def call(name, kind):
        try:
            return rospy.ServiceProxy(name, kind)()
        except (rospy.ServiceException, rospy.ROSException):
            return None

    models = set(env.world.world.models)

    def spawned():
        there = call("/gazebo/get_world_properties", GetWorldProperties)
        return there and models <= set(there.model_names)

    graph.wait(spawned, f"the models {', '.join(sorted(models))}")
    wanted = {}
    for namespace, name in env.world.controllers:
        wanted.setdefault(namespace, set()).add(name)
    for namespace, names in wanted.items():

        def running(namespace=namespace, names=names):
            there = call(f"{namespace}/controller_manager/list_controllers", ListControllers)
            state = {each.name: each.state for each in there.controller} if there else {}
            return all(state.get(name) == "running" for name in names)

        graph.wait(running, f"the controllers {', '.join(sorted(names))} of '{namespace}'")


def wait_joined():
    """Wait until the launch file's other nodes are on the graph with their topics.

    What is no node of ROS, or takes longer than STARTS, is not waited for: it need not ever join.
    """
    import rosgraph
    from roslaunch.netapi import list_processes

    master = rosgraph.Master("/environment_beside_launch_waits")
    end, known, changed = time.monotonic() + STARTS, None, 0.0
    while time.monotonic() < end:
        state = master.getSystemState()
        nodes = {node.lstrip("/") for kind in state for _, names in kind for node in names}
        running = {each.name.rpartition("-")[0] for each in list_processes() if each.is_alive}
        if state != known:
            known, changed = state, time.monotonic()
        elif running - {""} <= nodes and time.monotonic() - changed > QUIET:
            return
        time.sleep(0.05)


class Both:
    """The environment and the graph under the same commands."""

    def __init__(self, env, graph):
        import rospy
        from gazebo_msgs.srv import GetModelState
        from paddock_gym.driver.robot import message_of
        from paddock_gym.envs.describe import policy_description
        from roslib.message import get_message_class

        from bullet_bridge.srv import Step

        self.env, self._graph, self._message_of = env, graph, message_of
        about = policy_description(env)
        env.reset(seed=1)
        self.topics = [Topic(name, each, env) for name, each in about.sources.items()]
        self._publishers = [
            (rospy.Publisher(topic, get_message_class(kind), queue_size=1), kind, count)
            for topic, kind, count in about.actions.topics
        ]
        for publisher, _, _ in self._publishers:
            graph.wait(publisher.get_num_connections, f"a subscriber of {publisher.name}")
        self._wait_subscribed({topic.name for topic in self.topics})
        rospy.wait_for_service("/gazebo/step", LIMIT)
        self._step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)
        self._state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState, persistent=True)

    def _wait_subscribed(self, topics):
        """Wait until the simulator, and its relay, send all topics to this node."""
        import xmlrpc.client

        import rosgraph
        import rospy

        def there():
            links = set()
            master = rosgraph.Master(rospy.get_name())
            for node in {n for name, nodes in master.getSystemState()[0] for n in nodes
                         if name in topics}:  # fmt: skip
                server = xmlrpc.client.ServerProxy(master.lookupNode(node))
                _, _, rows = server.getBusInfo(rospy.get_name())
                links |= {r[4] for r in rows if r[1] == rospy.get_name() and r[2] == "o" and r[5]}
            return topics <= links

        self._graph.wait(there, f"subscriptions to {', '.join(sorted(topics))}")

    def act(self, action):
        """One action in both; compare what came of it."""
        before = self.env.world.world.step_count
        self.env.step(action)
        numbers, begin = self.env.actions.numbers(action).tolist(), 0
        for publisher, kind, count in self._publishers:
            publisher.publish(self._message_of(kind, numbers[begin : begin + count]))
            begin += count
        names = [publisher.name for publisher, _, _ in self._publishers]
        answer = self._step(self.env.world.world.step_count - before, names, [1] * len(names))
        if not answer.success:
            raise SystemExit(f"/gazebo/step: {answer.status_message}")
        for topic in self.topics:
            topic.compare(self._graph)

    def poses_differ(self):
        """Largest difference of a model's pose [m, of a quaternion], and the model."""
        gaps = {}
        for name, model in self.env.world.world.models.items():
            pose = self._state(name, "").pose
            at, turn = pose.position, pose.orientation
            over = np.array([at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w])
            here = np.array([*model.pose.position, *model.pose.orientation])
            gaps[name] = float(abs(over - here).max())
        name = max(gaps, key=gaps.get)
        return gaps[name], name


def moved(env, before):
    """Way of the robot [m] and largest change of a joint [rad, m] since a place()."""
    (position, joints), (old, old_joints) = place(env), before
    change = max((abs(a - b) for a, b in zip(joints, old_joints)), default=0.0)
    return float(np.linalg.norm(np.subtract(position, old))), float(change)


def place(env):
    """Position of the robot [m], positions of its joints [rad, m]."""
    model = env.agent.model
    joints = model.joints.columns(range(len(model.joints.names)))[0] if model.joints.names else []
    return model.pose.position, list(joints)


def run(words, actions, alone, action):
    """Compare and print; a list of what is wrong."""
    import rospy

    launch, wrong = " ".join(map(shlex.quote, words)), []
    env = make(launch, action)
    print(f"  action {env.action_space}: {'; '.join(env.actions.names)}")
    for name, space in env.observation_space.spaces.items():
        print(f"  {name}: {space.shape} {space.dtype}")
    graph = Graph(launch, simulator_of(launch))
    try:
        import rosgraph

        graph.wait(rosgraph.is_master_online, "the master")
        rospy.init_node("environment_beside_launch", anonymous=True, disable_signals=True)
        wait_up(graph, env)
        wait_joined()
        both = Both(env, graph)
        env.action_space.seed(5)
        for _ in range(actions):
            both.act(env.action_space.sample())
        before = place(env)
        constant = (0.25 * env.action_space.low + 0.75 * env.action_space.high).astype(np.float32)
        for _ in range(CONSTANT):
            both.act(constant)
        way, turn = moved(env, before)
        gap, model = both.poses_differ()
    finally:
        graph.close()
    for topic in both.topics:
        text = topic.differs or f"{topic.compared} messages, all the same"
        text += "" if topic.changes else "; the observation never changed"
        print(f"  {topic.name}: {text}")
        if topic.differs:
            wrong.append(f"{topic.name}: {text}")
    print(
        f"  constant command: {way:.3f} m, a joint by {turn:.3f}; poses differ by {gap:g} ({model})"
    )
    if gap > 1e-9:
        wrong.append(f"the pose of {model} differs by {gap:g}")
    if max(way, turn) < MOVES:
        wrong.append(f"a constant command moves the robot by {way:g} m and no joint by {MOVES}")
    env.reset(seed=2)
    begin = time.perf_counter()
    for _ in range(alone):
        env.step(env.action_space.sample())
    if alone:
        took = time.perf_counter() - begin
        print(f"  alone: {alone} random actions, {alone / took:.1f} a second")
    env.close()
    return wrong


def main():
    """Compare a launch file; exit 1 where something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("launch", nargs="+", help="PACKAGE FILE.launch ARG:=VALUE ...")
    parser.add_argument("--action", action="append", default=[], help="topic that is commanded")
    parser.add_argument("--actions", type=int, default=50, help="random ones in both")
    parser.add_argument("--alone", type=int, default=0, help="random ones of the environment alone")
    given = parser.parse_args()
    print(" ".join(given.launch))
    wrong = run(given.launch, given.actions, given.alone, tuple(given.action))
    for text in wrong:
        print(f"WRONG: {text}")
    print("not the same" if wrong else "the same")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
