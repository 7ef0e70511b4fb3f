// The library that packages link by its name; all of it is in the header.
#include <gazebo_plugins/gazebo_ros_utils.h>
