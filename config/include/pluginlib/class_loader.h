// The name that pluginlib had for class_loader.hpp until ROS Melodic.
#pragma once
#include <pluginlib/class_loader.hpp>
