#!/usr/bin/env python3
"""One message as a node of the install space gets it: install_observer.py TOPIC TYPE LIMIT.

Prints JSON: the message's fields; for an array of bytes, its length and how many different values
it holds.
"""

import json
import sys

import roslib.message
import rospy


def main():
    """Waits for one message and prints what it holds."""
    topic, kind, limit = sys.argv[1:]
    message_class = roslib.message.get_message_class(kind)
    rospy.init_node("install_observer", anonymous=True)
    message = rospy.wait_for_message(topic, message_class, float(limit))
    fields = {}
    for name in message.__slots__:
        value = getattr(message, name)
        if isinstance(value, bytes):
            fields[name] = {"length": len(value), "values": len(set(value))}
        elif isinstance(value, (int, float, str, list, tuple)):
            fields[name] = value
    print(json.dumps(fields))


if __name__ == "__main__":
    main()
