// The name that class_loader had for register_macro.hpp until ROS Melodic.
#pragma once
#include <class_loader/register_macro.hpp>
