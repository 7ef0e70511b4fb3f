// The name that class_loader had for class_loader.hpp until ROS Melodic.
#pragma once
#include <class_loader/class_loader.hpp>
