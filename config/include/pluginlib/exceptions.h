// The name that pluginlib had for exceptions.hpp until ROS Melodic.
#pragma once
#include <pluginlib/exceptions.hpp>
