// The functions by which the simulator has a gazebo::physics::World in its process.
//
// Of one thread, the simulation's. Each returns whether it succeeded; paddock_error() says why not.
// Compiled with -fno-access-control: Gazebo's server is a friend of what is private here.
#include <gazebo/common/common.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/transport/transport.hh>
#include <ros/ros.h>
#include <sdf/sdf.hh>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>

#include "changes.hh"
#include "engine.hh"
#include "faults.hh"
#include "host.hh"
#include "joint.hh"
#include "link.hh"

using namespace gazebo;
using paddock::engine;
using paddock::fail;
using paddock::guarded;
using paddock::modelOf;
using paddock::read;
using paddock::tables;

namespace {

physics::WorldPtr g_world;
std::unique_ptr<ros::AsyncSpinner> g_spinner;
std::string g_error, g_text;
std::map<std::string, unsigned int> g_inserted;  // models that the solver has -> their connections
unsigned int g_own_connections = 0;  // to the events of a step, of Gazebo itself and of its models

// Functions that are called at each step.
unsigned int connections() {
  using event::Events;
  return Events::worldUpdateBegin.ConnectionCount() + Events::worldUpdateEnd.ConnectionCount() +
         Events::beforePhysicsUpdate.ConnectionCount();
}

ignition::math::Pose3d pose(const double *numbers) {
  return {paddock::get(numbers), paddock::getTurn(numbers + 3)};
}

// Messages go from node to node in this process, without a master and without a socket.
void startTransport() {
  const auto manager = transport::ConnectionManager::Instance();
  transport::TopicManager::Instance()->Init();
  manager->masterConn.reset(new transport::Connection);
  manager->serverConn.reset(new transport::Connection);
  manager->namespaces.push_back("default");  // else the first node waits for one
  manager->initialized = true;
}

void startRos(const char *master, const char *name) {
  const ros::M_string remappings{{"__ip", "127.0.0.1"}, {"__master", master}};
  ros::init(remappings, name, ros::init_options::NoSigintHandler);
  g_spinner.reset(new ros::AsyncSpinner(0));
  g_spinner->start();
}

// As World::Step() of a first iteration, which sets the clocks; there is nothing to simulate yet.
void startClocks() {
  g_world->Physics()->SetRealTimeUpdateRate(0.0);  // the pace is the caller's
  g_world->_SetSensorsInitialized(true);
  g_world->RunBlocking(1);
  g_world->SetSimTime(common::Time::Zero);
  engine().is_open = true;
}

// Forget a model; false: it is not there.
bool forgetModel(const std::string &name) {
  const auto found = g_inserted.find(name);
  if (found == g_inserted.end()) return false;
  g_own_connections -= found->second;
  g_inserted.erase(found);
  return true;
}

}  // namespace

namespace paddock {

bool fail(const std::string &error) {
  g_error = error;
  return false;
}

sdf::ElementPtr read(const char *text, const char *tag) {
  sdf::SDFPtr document(new sdf::SDF);
  sdf::init(document);
  sdf::Errors errors;
  if (!sdf::readString(text, document, errors) || !document->Root()->HasElement(tag)) {
    std::ostringstream message;
    message << "sdformat reads no <" << tag << ">";
    for (const auto &error : errors) message << "; " << error.Message();
    fail(message.str());
    return {};
  }
  return document->Root()->GetElement(tag);
}

physics::ModelPtr modelOf(const char *name) {
  const auto model = g_world ? g_world->ModelByName(name) : physics::ModelPtr();
  if (!model) fail(std::string("Gazebo's world has no model '") + name + "'");
  return model;
}

}  // namespace paddock

extern "C" {

// Names of the columns that paddock_tables() takes, one after the other.
const char *paddock_columns() {
#define X(name) #name " "
  return PADDOCK_BODY_COLUMNS(X) PADDOCK_JOINT_COLUMNS(X);
#undef X
}

const char *paddock_error() { return g_error.c_str(); }

// Version of Gazebo that this was compiled against.
const char *paddock_version() { return GAZEBO_VERSION_FULL; }

// Start everything but a world.
//   master, name: URI of ROS's master, and of the node of the plugins; without a master none.
bool paddock_open(const char *master, const char *name) {
  setenv("IGN_IP", "127.0.0.1", 1);
  setenv("GAZEBO_IP", "127.0.0.1", 1);
  setenv("ALSOFT_DRIVERS", "null", 0);  // no sound
  setenv("GAZEBO_MODEL_DATABASE_URI", "http://127.0.0.1:9/", 0);  // nothing is downloaded
  return guarded([&] {
    if (!paddock::keepToLoopback())
      return fail("sockets of the libraries cannot be kept to the loopback interface");
    paddock::watchFaults();
    // Destructors of plugins whose threads run would end the process by SIGABRT.
    on_exit([](int status, void *) { fflush(nullptr), _exit(status); }, nullptr);
    common::Console::SetQuiet(false);
    common::load();
    sdf::setFindCallback([](const std::string &file) { return common::find_file(file); });
    startTransport();
    physics::load();
    paddock::registerEngine();
    if (*master) startRos(master, name);
    return true;
  });
}

// What the engine calls: the solver's step, its rays and its contacts; see Engine.
void paddock_calls(void (*step)(),
                   void (*cast)(const double *, const double *, int, double, double, double *),
                   void (*contacts)()) {
  auto &all = engine();
  all.step = step, all.cast = cast, all.contacts = contacts;
}

// Make the world of an SDF, without models.
bool paddock_world(const char *text) {
  return guarded([&] {
    const auto element = read(text, "world");
    if (!element) return false;
    g_world = physics::create_world();
    physics::load_world(g_world, element);
    physics::init_world(g_world);
    startClocks();
    g_own_connections = connections();
    return true;
  });
}

// The solver's tables, of which paddock_step() makes use from now on.
//   columns: numbers of those of paddock_columns(), in their order.
//   rest: [s] and steps after which a body sleeps; infinite: mass of what forces do not move [kg].
void paddock_tables(
    double *bodies, double *joints, const int *columns, const double *rest, double infinite) {
  auto &all = tables();
  all.bodies = bodies, all.joints = joints;
  std::copy(columns, columns + paddock::col::COLUMNS, all.column);
  all.rest.time = rest[0], all.rest.steps = rest[1], all.infinite = infinite;
}

// Insert the model of an SDF, without plugins.
bool paddock_insert(const char *text) {
  return guarded([&] {
    const auto element = read(text, "model");
    if (!element) return false;
    paddock::isInserting() = true;
    const std::shared_ptr<void> end(nullptr, [](void *) { paddock::isInserting() = false; });
    element->SetParent(g_world->SDF());
    g_world->SDF()->InsertElement(element);
    const unsigned int before = connections();
    const auto model = g_world->LoadModel(element, g_world->BaseByName(g_world->Name()));
    if (!model) return fail("the model is in Gazebo's world already");
    paddock::Quiet quiet;
    model->Init();
    const unsigned int own = connections() - before;  // each link has one
    g_inserted[model->GetName()] = own, g_own_connections += own;
    return true;
  });
}

bool paddock_remove(const char *name) {
  return guarded([&] {
    paddock::forgetPlugins(name);
    if (engine().remove_sensors) engine().remove_sensors(name);
    if (!modelOf(name)) return false;
    forgetModel(name);
    g_world->RemoveModel(name);
    return true;
  });
}

// Say which row of bodies a link is.
//   frame: pose of the link's frame in that of the body, (x, y, z) [m] and (x, y, z, w).
//   primary: the body is the link's own, and no other link's.
bool paddock_bind_link(
    const char *model, const char *name, int row, const double *frame, bool primary) {
  const auto found = modelOf(model);
  if (!found) return false;
  const auto link = boost::dynamic_pointer_cast<paddock::RowLink>(found->GetLink(name));
  if (!link) return fail(std::string("Gazebo's model '") + model + "' has no link '" + name + "'");
  link->Bind(row, pose(frame), primary);
  return true;
}

// Say which row of joints a joint is, and which rows of bodies it connects.
bool paddock_bind_joint(const char *model, const char *name, int row, int one, int two) {
  const auto found = modelOf(model);
  if (!found) return false;
  const auto joint = boost::dynamic_pointer_cast<paddock::RowJoint>(found->GetJoint(name));
  if (!joint) return fail(std::string("Gazebo's model '") + model + "' has no joint '" + name + "'");
  joint->Bind(row, one, two);
  return true;
}

// The next joint that a plugin has made, attached or detached; null: there is none.
//   Returns its number, 1: attach or 0: detach, its type, and model and link of parent and child
//   (empty: the world), a line each.
//   numbers: get the pose of its frame in the child's, axis, limits, effort, velocity, damping,
//   friction, stiffness and rest of a spring: 18.
const char *paddock_next_joint(double *numbers) {
  paddock::JointChange change;
  boost::shared_ptr<paddock::RowJoint> joint;
  do {
    if (!paddock::nextChange(&change)) return nullptr;
    joint = paddock::madeJoint(change.number);
  } while (change.attach && !joint);
  std::ostringstream text;
  text << change.number << "\n" << change.attach << "\n";
  if (!change.attach) return (g_text = text.str()).c_str();
  text << (joint->HasType(physics::Base::HINGE_JOINT)    ? "revolute"
           : joint->HasType(physics::Base::SLIDER_JOINT) ? "prismatic"
                                                         : "fixed");
  for (const auto &link : {joint->GetParent(), joint->GetChild()})
    text << "\n" << (link ? link->GetParentModel()->GetName() : "")
         << "\n" << (link ? link->GetName() : "");
  const auto place = joint->InitialAnchorPose();
  paddock::put(numbers, place.Pos()), paddock::putTurn(numbers + 3, place.Rot());
  std::fill(numbers + 7, numbers + 18, 0.0);
  if (joint->DOF() > 0) {
    const double values[] = {
        joint->LowerLimit(0), joint->UpperLimit(0), joint->GetEffortLimit(0),
        joint->GetVelocityLimit(0), joint->GetDamping(0),
        joint->GetParam("friction", 0),
        joint->GetStiffness(0), joint->GetSpringReferencePosition(0)};
    paddock::put(numbers + 7, joint->OwnAxis());
    std::copy(values, values + 8, numbers + 10);
  }
  return (g_text = text.str()).c_str();
}

// The next model that a plugin inserts or removes; null: there is none.
//   Returns its name, a text or a URI.
//   facts: get the kind (see ModelChange), whether there is a pose, and whether it may be renamed.
//   numbers: get the pose: 7.
const char *paddock_next_model(int *facts, double *numbers) {
  paddock::ModelChange change;
  if (g_world->ModelCount() < g_inserted.size())
    for (const auto &each : g_inserted)
      if (!g_world->ModelByName(each.first)) change.what = each.first;
  if (!forgetModel(change.what) && !paddock::nextModel(&change)) return nullptr;
  facts[0] = change.kind, facts[1] = change.has_pose, facts[2] = change.may_rename;
  paddock::put(numbers, change.pose.Pos()), paddock::putTurn(numbers + 3, change.pose.Rot());
  return (g_text = change.what).c_str();
}

// Say which row such a joint is; see paddock_bind_joint().
void paddock_bind_made(int number, int row, int one, int two) {
  if (const auto joint = paddock::madeJoint(number)) joint->Bind(row, one, two);
}

// Put a model to a pose that the solver has no row for.
bool paddock_place(const char *name, const double *numbers) {
  return guarded([&] {
    const auto model = modelOf(name);
    if (!model) return false;
    paddock::Quiet quiet;
    model->SetWorldPose(pose(numbers));
    return true;
  });
}

// Take over poses that were set since the last step.
void paddock_pull() {
  for (auto link : paddock::boundLinks()) link->Pull(true);
}

// Names of the collisions whose contacts are wanted, one a line; "*": of all.
const char *paddock_watched_collisions() {
  const auto manager = g_world->Physics()->GetContactManager();
  g_text.clear();
  if (manager->NeverDropContacts() || manager->contactPub->HasConnections()) g_text = "*";
  if (!g_text.empty()) return g_text.c_str();
  for (const auto &each : manager->customContactPublishers) {
    for (const auto &name : each.second->collisionNames) g_text += name + "\n";
    for (const auto collision : each.second->collisions)
      g_text += collision->GetScopedName() + "\n";
  }
  return g_text.c_str();
}

// Add contacts of a pair of collisions in the last step.
//   numbers: of each place [m], normal and depth [m], and force [N] and torque [N m] on the first's
//   link about its center of mass and on the second's, in their axes: 19.
bool paddock_add_contacts(const char *first, const char *second, const double *numbers, int count) {
  const auto find = [](const char *name) {
    return boost::dynamic_pointer_cast<physics::Collision>(g_world->BaseByName(name)).get();
  };
  const auto manager = g_world->Physics()->GetContactManager();
  const auto contact = manager->NewContact(find(first), find(second), g_world->SimTime());
  if (!contact) return false;
  contact->count = std::min(count, MAX_CONTACT_JOINTS);
  for (int i = 0; i < contact->count; ++i, numbers += 19) {
    contact->positions[i] = paddock::get(numbers);
    contact->normals[i] = paddock::get(numbers + 3);
    contact->depths[i] = numbers[6];
    auto &wrench = contact->wrench[i];
    wrench.body1Force = paddock::get(numbers + 7), wrench.body1Torque = paddock::get(numbers + 10);
    wrench.body2Force = paddock::get(numbers + 13), wrench.body2Torque = paddock::get(numbers + 16);
  }
  return true;
}

// Load a plugin of a model, or of the world (model: empty), as Gazebo does.
//   text: an SDF whose model, or world, has it; folder: of its library.
bool paddock_load_plugin(const char *name, const char *text, const char *folder) {
  return guarded([&] {
    const bool of_world = !*name;
    const auto model = of_world ? physics::ModelPtr() : modelOf(name);
    if (!of_world && !model) return false;
    const auto holder = read(text, of_world ? "world" : "model");
    if (!holder) return false;
    const auto element = holder->GetElement("plugin");
    const auto file = element->Get<std::string>("filename");
    common::SystemPaths::Instance()->AddPluginPaths(folder);
    const std::string path = std::string(folder) + "/" + file;
    const std::string reason = paddock::loadLibrary(path);
    if (!reason.empty()) return fail(reason);
    const paddock::Owner owner(path, element->Get<std::string>("name"), name);
    if (of_world) {
      g_world->LoadPlugin(element);
      return paddock::takeThrown(&g_error) ? false : true;
    }
    const auto before = model->plugins.size();
    model->GetSDF()->InsertElement(element);
    model->LoadPlugin(element);
    if (model->plugins.size() > before) return true;
    if (!paddock::takeThrown(&g_error))
      g_error = "it registers no model plugin, or its constructor failed";
    return false;
  });
}

// Whether no plugin is called at each step, so that several can be made by one paddock_step().
bool paddock_is_idle() {
  if (engine().update_sensors || *paddock_watched_collisions() || connections() > g_own_connections)
    return false;
  for (const auto &model : g_world->Models()) {
    if (!model->jointAnimations.empty()) return false;
    const auto &control = model->jointController;
    if (control && !(control->GetForces().empty() && control->GetPositions().empty() &&
                     control->GetVelocities().empty()))
      return false;
  }
  return true;
}

// Make a step of some length that begins at a simulated time [s]; where nobody is called at each
// step, the solver may make several in it, `count`.
// Returns whether nothing was thrown; made: whether the solver's step was made.
bool paddock_step(double time, double length, int count, bool *made) {
  auto &all = engine();
  all.has_stepped = false, all.is_stepping = true;
  const auto physics = g_world->Physics();
  if (physics->GetMaxStepSize() != length) physics->SetMaxStepSize(length);
  g_world->SetSimTime(common::Time(time));
  const paddock::Watch watch;
  const bool done = guarded([&] {
    g_world->Step();
    transport::TopicManager::Instance()->ProcessNodes();
    if (all.update_sensors) all.update_sensors();
    if (count > 1) g_world->SetSimTime(common::Time(time + count * length));
    return true;
  });
  if (!done) paddock::takeThrown(&g_error);
  *made = all.has_stepped || !g_world->PhysicsEnabled();
  all.is_stepping = false;
  return done;
}

// Unload the plugin of a model by which the last error was thrown.
// Returns what it was, for a message; empty: it is not known.
const char *paddock_unload_faulty() {
  std::string model, plugin;
  g_text = paddock::faulty(&model, &plugin);
  if (g_text.empty()) return g_text.c_str();
  guarded([&] {
    if (model.empty()) return g_world->RemovePlugin(plugin), true;
    const auto found = g_world->ModelByName(model);
    if (!found) return false;
    auto &all = found->plugins;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const ModelPluginPtr &each) { return each->GetHandle() == plugin; }),
              all.end());
    return true;
  });
  return g_text.c_str();
}

// The next model without rows that a plugin has moved; null: there is none.
//   numbers: gets its pose.
const char *paddock_next_moved(double *numbers) {
  static std::vector<physics::ModelPtr> moved;
  if (moved.empty()) moved = paddock::takeMoved();
  if (moved.empty()) return nullptr;
  const auto model = moved.back();
  moved.pop_back();
  const auto where = model->WorldPose();
  paddock::put(numbers, where.Pos()), paddock::putTurn(numbers + 3, where.Rot());
  g_text = model->GetName();
  return g_text.c_str();
}

// Gravity that a plugin has set since the last call [m/s^2].
bool paddock_gravity(double *numbers) {
  if (!engine().gravity_changed) return false;
  engine().gravity_changed = false;
  paddock::put(numbers, g_world->Gravity());
  return true;
}

// Tell plugins of a reset, of time, too, or of the models alone; the solver has reset its rows.
bool paddock_reset(bool time) {
  return guarded([&] {
    {
      paddock::Quiet quiet;
      if (time)
        g_world->Reset();
      else
        g_world->ResetEntities(physics::Base::MODEL);
    }
    for (auto link : paddock::boundLinks()) link->Forget();
    paddock_pull();
    return true;
  });
}

void paddock_close() {
  if (g_spinner) g_spinner->stop();
  if (ros::isStarted()) ros::shutdown();
}
}
