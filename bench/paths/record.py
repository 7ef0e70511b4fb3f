#!/usr/bin/env python3
"""Drive a robot by a plan, in Gazebo or in Paddock, and save where it went.

    python3 record.py PLAN.json NAME.gazebo.json      while its launch file runs; needs rospy alone

PLAN.json has "model", its name in the simulator, and "plan", a list of phases: name, simulated
seconds, and a list of [topic, type, message] that are sent 25 times a second meanwhile; "patience",
wall time for the model and for subscribers [s], 120 if it is missing. NAME is the same for both
simulators. The file gets "paths": phase -> list of [time [s], x, y [m], yaw [rad]].
"""

import json
import math
import sys
import time

import genpy
import roslib.message
import rospy
from gazebo_msgs.srv import GetModelState

PERIOD, SAMPLE = 0.04, 0.015  # wall time between two commands, two samples [s]
PATIENCE = 120.0  # [s]
SLOWEST = 10.0  # wall time that a simulated second may take [s]


class Recorder:
    """A model that is driven.

    Args:
        model: name.
        patience: wall time that it and subscribers may take to be there [s].
    """

    def __init__(self, model, patience):
        self._model, self._patience = model, patience
        rospy.wait_for_service("/gazebo/get_model_state", patience)
        self._state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState, persistent=True)
        limit = time.monotonic() + patience
        while not (found := self._state(model, "world")).success:
            if time.monotonic() > limit:
                raise RuntimeError(f"model '{model}' is not there: {found.status_message}")
            time.sleep(0.2)

    def sample(self):
        """[time, x, y, yaw] now."""
        found = self._state(self._model, "world")
        place, q = found.pose.position, found.pose.orientation
        yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
        return [found.header.stamp.to_sec(), place.x, place.y, yaw]

    def phase(self, seconds, commands):
        """Samples of a phase.

        Args:
            commands: list of (publisher, message).
        """
        limit = time.monotonic() + self._patience
        while any(not publisher.get_num_connections() for publisher, _ in commands):
            if time.monotonic() > limit:
                missing = [p.name for p, _ in commands if not p.get_num_connections()]
                raise RuntimeError(f"nobody subscribes to {', '.join(missing)}")
            time.sleep(0.05)
        samples, following = [self.sample()], 0.0
        limit = time.monotonic() + SLOWEST * seconds
        while samples[-1][0] < samples[0][0] + seconds:
            if time.monotonic() > limit:
                raise RuntimeError(f"{seconds:g} simulated s took more than {SLOWEST:g} times that")
            if time.monotonic() >= following:
                for publisher, message in commands:
                    if hasattr(message, "header"):
                        message.header.stamp = rospy.Time.from_sec(samples[-1][0])
                    publisher.publish(message)
                following = time.monotonic() + PERIOD
            time.sleep(SAMPLE)
            samples.append(self.sample())
        return samples


def command_of(topic, kind, content):
    """(Publisher, message) of a command."""
    message_class = roslib.message.get_message_class(kind)
    if message_class is None:
        raise RuntimeError(f"'{kind}' of topic '{topic}' is no message type")
    message = message_class()
    genpy.message.fill_message_args(message, [content] if isinstance(content, dict) else content)
    return rospy.Publisher(topic, message_class, queue_size=1), message


def main(plan, output):
    """Record; returns the exit code."""
    rospy.init_node("record_path", anonymous=True, disable_signals=True, disable_rostime=True)
    try:
        with open(plan) as stream:
            asked = json.load(stream)
        recorder, paths = Recorder(asked["model"], asked.get("patience", PATIENCE)), {}
        for name, seconds, commands in asked["plan"]:
            paths[name] = recorder.phase(seconds, [command_of(*command) for command in commands])
    except (OSError, ValueError, KeyError, RuntimeError, rospy.ROSException) as error:
        print(f"record.py: {plan}: {error}", file=sys.stderr)
        return 2
    with open(output, "w") as stream:
        json.dump({"paths": paths}, stream)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
