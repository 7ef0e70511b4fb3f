// What plugins ask Gazebo's World for that the solver has to do: models that are inserted.
#pragma once
#include <gazebo/physics/physics.hh>

#include <string>

namespace paddock {

// A model that a plugin inserts or removes.
struct ModelChange {
  enum Kind { REMOVE, TEXT, FILE, CLONE };
  Kind kind = REMOVE;
  std::string what;         // name of the model, or of the one to copy; text of an SDF or URDF; URI
  bool has_pose = false;    // else that of the text
  bool may_rename = false;  // where the name is taken
  ignition::math::Pose3d pose;
};

// The next one that is inserted; false: there is none.
bool nextModel(ModelChange *change);

}  // namespace paddock
