#include "changes.hh"

#include <deque>
#include <mutex>

namespace paddock {

namespace {

std::deque<ModelChange> g_models;
std::mutex g_models_mutex;  // plugins insert models in threads of ROS, too

void demandModel(const ModelChange &change) {
  std::lock_guard<std::mutex> lock(g_models_mutex);
  g_models.push_back(change);
}

}  // namespace

bool nextModel(ModelChange *change) {
  std::lock_guard<std::mutex> lock(g_models_mutex);
  if (g_models.empty()) return false;
  *change = g_models.front();
  g_models.pop_front();
  return true;
}

}  // namespace paddock

// These take the place of Gazebo's own functions, which would insert the model into its world alone:
// the solver gets it first. This library is loaded before Gazebo's, so that all calls come here.
namespace gazebo {
namespace physics {

using paddock::ModelChange;

void World::InsertModelFile(const std::string &file) {
  ModelChange change;
  change.kind = ModelChange::FILE, change.what = file;
  paddock::demandModel(change);
}

void World::InsertModelString(const std::string &text) {
  ModelChange change;
  change.kind = ModelChange::TEXT, change.what = text;
  paddock::demandModel(change);
}

void World::InsertModelSDF(const sdf::SDF &document) { InsertModelString(document.ToString()); }

void World::OnFactoryMsg(ConstFactoryPtr &message) {
  ModelChange change;
  if (!message->sdf().empty()) {
    change.kind = ModelChange::TEXT, change.what = message->sdf();
  } else if (!message->sdf_filename().empty()) {
    change.kind = ModelChange::FILE, change.what = message->sdf_filename();
  } else if (!message->clone_model_name().empty()) {
    change.kind = ModelChange::CLONE, change.what = message->clone_model_name();
  } else {
    gzerr << "Unable to load sdf from factory message.\n";
    return;
  }
  change.may_rename = message->allow_renaming();
  change.has_pose = message->has_pose();
  if (change.has_pose) change.pose = msgs::ConvertIgn(message->pose());
  paddock::demandModel(change);
}

}  // namespace physics
}  // namespace gazebo
