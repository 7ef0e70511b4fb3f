"""Launch files with the oddities of published ones: what their tests share."""

import rospy
from controller_manager_msgs.srv import ListControllers
from drop_in_workspace import MasterCase, Workspace
from gazebo_msgs.srv import GetModelState
from geometry_msgs.msg import Twist
from sim_client import START_LIMIT, Recorder, wait_connected, wait_until


def lengths(states):
    """Numbers of positions, velocities and efforts."""
    return [len(values) for values in (states.position, states.velocity, states.effort)]


def forward(speed):
    """A Twist of a speed [m/s]."""
    twist = Twist()
    twist.linear.x = speed
    return twist


class HarbourCase(MasterCase):
    """Each test is one launch file of harbour_fleet."""

    NODE = "harbour_test"

    @staticmethod
    def make_workspace():
        return Workspace("harbour_fleet")

    def state(self, model):
        return rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)(model, "")

    def wait_model(self, launched, model):
        def there():
            if not launched.running():
                raise AssertionError(f"the launch ended:\n{launched.output()}")
            try:
                return self.state(model).success
            except rospy.ServiceException:
                return False

        wait_until(there, f"model {model}", START_LIMIT)

    def wait_running(self, namespace, *names):
        def running():
            service = rospy.ServiceProxy(
                f"{namespace}/controller_manager/list_controllers", ListControllers
            )
            try:
                states = {item.name: item.state for item in service().controller}
            except rospy.ServiceException:
                return False
            return all(states.get(name) == "running" for name in names)

        wait_until(running, f"{', '.join(names)} running in {namespace or '/'}", START_LIMIT)

    def record(self, topic, kind):
        recorder = Recorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def publisher(self, topic):
        publisher = rospy.Publisher(topic, Twist, queue_size=10)
        self.addCleanup(publisher.unregister)
        wait_connected(publisher, topic)
        return publisher
