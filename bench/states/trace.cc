// World plugin of Gazebo 11: commands joints at given steps and prints where all links are.
//
// Environment: TRACE_OUT (file), TRACE_STEPS (number), TRACE_EVERY (steps between two prints),
// TRACE_COMMANDS (file with lines "step joint KIND value motor's_effort"; KIND is velocity of the
// joint's motor, position, effort, or imposed: a velocity that is set before each step; planar: the
// joint's model moves along x with the value and turns with the last number before each step; winch
// and detach: what a HarnessPlugin hears, in the place of the joint stands its model).
// A printed step begins with "S number"; then each link has a line "L name", its center's position
// [m], its quaternion (x, y, z, w), linear and angular velocity [m/s, rad/s].

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>

#include <gazebo/common/common.hh>
#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/transport/transport.hh>

using namespace gazebo;

struct Command { std::string joint, kind; double value, effort; };

class Trace : public WorldPlugin
{
  physics::WorldPtr world;
  event::ConnectionPtr begin, end;
  FILE *out = nullptr;
  long step = 0, steps = 0, every = 1;
  std::multimap<long, Command> commands;
  std::map<std::string, Command> held;  // positions and efforts, which last
  transport::NodePtr node{new transport::Node()};
  std::map<std::string, transport::PublisherPtr> publishers;

  void Load(physics::WorldPtr _world, sdf::ElementPtr) override
  {
    this->world = _world;
    this->out = fopen(getenv("TRACE_OUT"), "w");
    this->steps = atol(getenv("TRACE_STEPS"));
    this->every = atol(getenv("TRACE_EVERY"));
    std::ifstream file(getenv("TRACE_COMMANDS"));
    long at;
    Command c;
    while (file >> at >> c.joint >> c.kind >> c.value >> c.effort) this->commands.emplace(at, c);
    this->begin = event::Events::ConnectWorldUpdateBegin(
        [this](const common::UpdateInfo &) { this->Apply(); });
    this->end = event::Events::ConnectWorldUpdateEnd([this]() { this->Print(); });
  }

  physics::JointPtr Find(const std::string &_name)
  {
    for (auto model : this->world->Models())
      if (auto joint = model->GetJoint(_name)) return joint;
    return nullptr;
  }

  // Publishes a number, or true, to a harness and waits until it is heard.
  void Tell(const Command &_c)
  {
    bool winch = _c.kind == "winch";
    auto &publisher = this->publishers[_c.joint + _c.kind];
    if (!publisher)
    {
      this->node->Init(this->world->Name());
      publisher = this->node->Advertise<msgs::GzString>(
          "~/" + _c.joint + "/harness/" + (winch ? "velocity" : "detach"));
      publisher->WaitForConnection();
    }
    msgs::GzString message;
    message.set_data(winch ? std::to_string(_c.value) : "true");
    publisher->Publish(message);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }

  void Apply()
  {
    auto due = this->commands.equal_range(this->step);
    for (auto i = due.first; i != due.second; ++i)
    {
      const Command &c = i->second;
      if (c.kind == "winch" || c.kind == "detach") { this->Tell(c); continue; }
      if (c.kind != "velocity") { this->held[c.joint] = c; continue; }
      auto joint = this->Find(c.joint);
      joint->SetParam("fmax", 0, c.effort);
      joint->SetParam("vel", 0, c.value);
    }
    for (auto model : this->world->Models())
      for (auto joint : model->GetJoints())
      {
        auto found = this->held.find(joint->GetName());
        if (found == this->held.end()) continue;
        const Command &c = found->second;
        if (c.kind == "effort") joint->SetForce(0, c.value);
        else if (c.kind == "imposed") joint->SetVelocity(0, c.value);
        else if (c.kind == "planar")
        {
          model->SetLinearVel(ignition::math::Vector3d(c.value, 0, 0));
          model->SetAngularVel(ignition::math::Vector3d(0, 0, c.effort));
        }
        else joint->SetPosition(0, c.value, true);
      }
  }

  void Print()
  {
    if (++this->step % this->every == 0)
    {
      fprintf(this->out, "S %ld\n", this->step);
      for (auto model : this->world->Models())
        if (!model->IsStatic())
          for (auto link : model->GetLinks())
          {
            auto p = link->WorldCoGPose().Pos(), v = link->WorldCoGLinearVel();
            auto q = link->WorldPose().Rot();
            auto w = link->WorldAngularVel();
            fprintf(this->out,
                    "L %s %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g "
                    "%.17g\n",
                    link->GetName().c_str(), p.X(), p.Y(), p.Z(), q.X(), q.Y(), q.Z(), q.W(), v.X(),
                    v.Y(), v.Z(), w.X(), w.Y(), w.Z());
          }
    }
    if (this->step >= this->steps) { fclose(this->out); _exit(0); }
  }
};

GZ_REGISTER_WORLD_PLUGIN(Trace)
