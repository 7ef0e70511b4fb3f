#!/usr/bin/python
import rospy
from std_msgs.msg import String

if __name__ == "__main__":
    rospy.init_node("horn")
    publisher = rospy.Publisher("horn", String, queue_size=1, latch=True)
    publisher.publish(String("toot"))
    rospy.spin()
