// What the libraries of the host share: errors, Gazebo's world, SDF.
#pragma once
#include <gazebo/common/Exception.hh>
#include <gazebo/physics/physics.hh>
#include <sdf/sdf.hh>

#include <string>

namespace paddock {

// Keep an error for paddock_error(); returns false.
bool fail(const std::string &error);

// What a function of Gazebo's or of a plugin throws is an error.
template <class Work>
bool guarded(const Work &work) {
  try {
    return work();
  } catch (const gazebo::common::Exception &error) {
    return fail(error.GetErrorStr());
  } catch (const std::exception &error) {
    return fail(error.what());
  } catch (...) {
    return fail("something that is no std::exception was thrown");
  }
}

// The first element of a name in an SDF; null: there is none, which is an error.
sdf::ElementPtr read(const char *text, const char *tag);

// A model of Gazebo's world; null: there is none, which is an error.
gazebo::physics::ModelPtr modelOf(const char *name);

}  // namespace paddock
