#pragma once
#include <boost/filesystem.hpp>
#include_next <pluginlib/class_loader.hpp>
