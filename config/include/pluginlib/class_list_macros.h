// The name that pluginlib had for class_list_macros.hpp until ROS Melodic.
#pragma once
#include <pluginlib/class_list_macros.hpp>
