// The interface of gazebo_plugins by which users' plugins publish: roscpp has a queue and a thread
// of its own, so messages go to it at once and in their order.
#ifndef GAZEBO_ROS_PUBQUEUE_H
#define GAZEBO_ROS_PUBQUEUE_H

#include <ros/ros.h>

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

template <class T>
class PubQueue {
 public:
  typedef boost::shared_ptr<PubQueue<T> > Ptr;
  void push(T &message, ros::Publisher &publisher) { publisher.publish(message); }
};

class PubMultiQueue {
 public:
  template <class T>
  boost::shared_ptr<PubQueue<T> > addPub() {
    return boost::make_shared<PubQueue<T> >();
  }
  void startServiceThread() {}
  void notifyServiceThread() {}
  void spinOnce() {}
  void spin() {}
};

#endif
