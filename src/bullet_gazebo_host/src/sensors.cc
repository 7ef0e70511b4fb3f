// Sensors of users' plugins: Gazebo's own, updated after each step as its threads would be.
//
// A library of its own, since Gazebo's sensors need its rendering library and OGRE: it is loaded
// where a <sensor> has a plugin in C++.
#include <gazebo/common/common.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/sensors/sensors.hh>
#include <gazebo/transport/transport.hh>

#include <memory>
#include <sstream>

#include "engine.hh"
#include "faults.hh"
#include "host.hh"
#include "link.hh"

using namespace gazebo;
using sensors::SensorManager;

namespace {

// When the sensors of one category are updated next; Gazebo has a thread for each.
struct Turn {
  common::Time due, last;
};
Turn g_turns[sensors::CATEGORY_COUNT];

// As SensorContainer::RunLoop(): the period of the fastest sensor after the last update.
void update(int category) {
  const auto container = SensorManager::Instance()->sensorContainers[category];
  if (container->sensors.empty()) return;
  const auto now = container->sensors.front()->world->SimTime();
  auto &turn = g_turns[category];
  if (now < turn.last) turn = {};  // time was reset
  if (now < turn.due) return;
  double rate = 0.0;
  for (const auto &sensor : container->sensors) rate = std::max(rate, sensor->UpdateRate());
  container->Update(false);
  turn.last = now;
  turn.due = now + common::Time(rate > 0.0 ? 1.0 / rate : 0.001);
}

void updateAll() {
  const auto manager = SensorManager::Instance();
  if (!manager->initSensors.empty() || !manager->removeSensors.empty()) manager->Update(false);
  for (int category : {sensors::RAY, sensors::OTHER}) update(category);
}

void removeOf(const char *model) {
  const auto manager = SensorManager::Instance();
  const std::string begin = std::string(model) + "::";
  for (const auto &sensor : manager->GetSensors())
    if (sensor->ParentName().compare(0, begin.size(), begin) == 0)
      manager->RemoveSensor(sensor->ScopedName());
  manager->Update(false);
}

void start() {
  auto &all = paddock::engine();
  if (all.update_sensors) return;
  sensors::SensorFactory::RegisterAll();
  SensorManager::Instance()->Init();
  all.update_sensors = updateAll, all.remove_sensors = removeOf;
}

}  // namespace

extern "C" {

// Make a sensor of a link or of a joint, with its plugins.
//   text: an SDF whose model's link has it; folders: of the plugins' libraries, with ':' between
//   them, in their order.
bool paddock_load_sensor(
    const char *model_name, const char *holder_name, const char *text, const char *folders) {
  return paddock::guarded([&] {
    const auto model = paddock::modelOf(model_name);
    if (!model) return false;
    physics::BasePtr place = model->GetLink(holder_name);
    if (!place) place = model->GetJoint(holder_name);
    if (!place)
      return paddock::fail("Gazebo's model '" + model->GetName() + "' has neither link nor joint '" +
                           holder_name + "'");
    const auto holder = paddock::read(text, "model");
    if (!holder) return false;
    const auto element = holder->GetElement("link")->GetElement("sensor");
    start();
    const auto type = element->Get<std::string>("type");
    const auto probe = sensors::SensorFactory::NewSensor(type);
    if (!probe) return paddock::fail("Gazebo has no sensor of type '" + type + "'");
    if (probe->Category() == sensors::IMAGE)
      return paddock::fail("sensors of type '" + type + "' need Gazebo's renderer, which is not here");
    std::vector<std::unique_ptr<paddock::Owner>> owners;
    std::istringstream rest(folders);
    auto plugin = element->HasElement("plugin") ? element->GetElement("plugin") : sdf::ElementPtr();
    for (; plugin; plugin = plugin->GetNextElement("plugin")) {
      std::string folder;
      std::getline(rest, folder, ':');
      common::SystemPaths::Instance()->AddPluginPaths(folder);
      const std::string path = folder + "/" + plugin->Get<std::string>("filename");
      const std::string reason = paddock::loadLibrary(path);
      if (!reason.empty()) return paddock::fail(reason);
      owners.emplace_back(new paddock::Owner(path, plugin->Get<std::string>("name"), model_name));
    }
    const auto manager = SensorManager::Instance();
    const auto world = model->GetWorld();
    const auto name =
        manager->CreateSensor(element, world->Name(), place->GetScopedName(), place->GetId());
    std::string problem = "it registers no plugin of a sensor, or its constructor failed";
    try {
      manager->Update(false);  // its plugins are loaded now
    } catch (...) {
      paddock::takeThrown(&problem);
      manager->initSensors.clear();  // Gazebo's server would end here
      world->_SetSensorsInitialized(true);
      return paddock::fail(problem);
    }
    const auto made = manager->GetSensor(name);
    if (made && made->plugins.size() >= owners.size()) {
      if (manager->sensorContainers[made->Category()]->sensors.size() == 1)
        update(made->Category());  // its thread starts
      return true;
    }
    if (made) manager->RemoveSensor(name), manager->Update(false);
    paddock::takeThrown(&problem);
    return paddock::fail(problem);
  });
}
}
