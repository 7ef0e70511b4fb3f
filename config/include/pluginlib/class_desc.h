// The name that pluginlib had for class_desc.hpp until ROS Melodic.
#pragma once
#include <pluginlib/class_desc.hpp>
