// The name that class_loader had for multi_library_class_loader.hpp until ROS Melodic.
#pragma once
#include <class_loader/multi_library_class_loader.hpp>
