// Acts on its model in one of several ways, <kind>, before each step.
#include <ros/ros.h>
#include <std_msgs/Float64.h>

#include <gazebo/common/common.hh>
#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/transport/transport.hh>

#include <functional>
#include <map>
#include <stdexcept>

namespace gazebo {

class Acting : public ModelPlugin {
 public:
  void Load(physics::ModelPtr model, sdf::ElementPtr sdf) override {
    this->model = model;
    kind = sdf->Get<std::string>("kind");
    value = sdf->HasElement("value") ? sdf->Get<double>("value") : 0.0;
    joint = model->GetJoint("hinge");
    slide = model->GetJoint("slide");
    if (ros::isInitialized()) {
      node.reset(new ros::NodeHandle(model->GetName()));
      command = node->subscribe("command", 1, &Acting::OnCommand, this);
      position = node->advertise<std_msgs::Float64>("position", 1);
    }
    if (kind == "factory") {
      transport.reset(new transport::Node);
      transport->Init(model->GetWorld()->Name());
      factory = transport->Advertise<msgs::Factory>("~/factory");
    }
    if (kind != "still")
      connection = event::Events::ConnectWorldUpdateBegin(std::bind(&Acting::Update, this));
  }

  void Reset() override { steps = 0; }

 private:
  void OnCommand(const std_msgs::Float64::ConstPtr &message) { value = message->data; }

  void Update() {
    ++steps;
    if (node) {
      std_msgs::Float64 message;
      message.data = model->WorldPose().Pos().X();
      position.publish(message);
    }
    Act();
  }

  void Act() {
    using ignition::math::Vector3d;
    const auto link = model->GetLink("link");
    if (kind == "force") link->AddForce(Vector3d(value, 0, 0));
    if (kind == "relative_force") link->AddRelativeForce(Vector3d(value, 0, 0));
    if (kind == "off_center") link->AddForceAtWorldPosition(
        Vector3d(0, value, 0), link->WorldCoGPose().Pos() + Vector3d(0.5, 0, 0));
    if (kind == "torque") link->AddTorque(Vector3d(0, 0, value));
    if (kind == "speed") model->SetLinearVel(Vector3d(value, 0, 0));
    if (kind == "pose") model->SetWorldPose({value, 2, 3, 0, 0, 0.001 * steps});
    if (kind == "effort") joint->SetForce(0, value);
    if (kind == "joint_speed") joint->SetVelocity(0, value);
    if (kind == "joint_position") joint->SetPosition(0, value);
    if (kind == "slide_speed") slide->SetVelocity(0, value);
    if (kind == "motor") joint->SetParam("fmax", 0, 100.0), joint->SetParam("vel", 0, value);
    if (kind == "pid" && steps == 1) {
      const auto name = joint->GetScopedName();
      model->GetJointController()->SetVelocityPID(name, common::PID(value, 0, 0));
      model->GetJointController()->SetVelocityTarget(name, 1.0);
    }
    if (kind == "heavy" && steps == 1) link->GetInertial()->SetMass(value), link->UpdateMass();
    if (kind == "gravity" && steps == 1) link->SetGravityMode(false);
    if (kind == "world_gravity" && steps == 1) model->GetWorld()->SetGravity({0, 0, value});
    if (kind == "physics_off" && steps == 10) model->GetWorld()->SetPhysicsEnabled(false);
    if (kind == "throw" && steps == 10) throw std::runtime_error("no more fuel");
    if (kind == "crash" && steps == 10) *static_cast<volatile int *>(nullptr) = 1;
    if (kind == "hang" && steps == 10) common::Time::Sleep(11);
    if (kind == "tell") Tell();
    if (kind == "weld" || kind == "crane") Connect();
    if (kind == "insert" || kind == "factory") Insert();
  }

  // Inserts a model that falls, by a function of World or a message, and removes it later.
  void Insert() {
    const auto world = model->GetWorld();
    const std::string text =
        "<sdf version='1.6'><model name='dropped'><pose>3 0 5 0 0 0</pose><link name='l'><inertial>"
        "<mass>2</mass></inertial></link></model></sdf>";
    if (steps == 5 && kind == "insert") world->InsertModelString(text);
    if (steps == 5 && kind == "factory") {
      msgs::Factory message;
      message.set_sdf(text);
      msgs::Set(message.mutable_pose(), ignition::math::Pose3d(4, 0, 6, 0, 0, 0));
      factory->Publish(message);
    }
    const auto dropped = world->ModelByName("dropped");
    if (dropped)
      std::cout << "dropped " << steps << " " << dropped->WorldPose().Pos().X() << " "
                << dropped->WorldPose().Pos().Z() << " " << dropped->WorldLinearVel().Z() << std::endl;
    if (dropped && steps == 40) world->RemoveModel(dropped);
  }

  // Joins the model "load" by a joint made now: held (weld), or turned about z (crane).
  void Connect() {
    if (steps == 5) {
      const auto world = model->GetWorld();
      const auto one = model->GetLink("link"), two = world->ModelByName("load")->GetLink("l");
      made = world->Physics()->CreateJoint("revolute", model);
      made->Attach(one, two);
      made->Load(one, two, ignition::math::Pose3d());
      made->SetModel(model);
      made->SetAxis(0, {0, 0, 1});
      if (kind == "weld") made->SetUpperLimit(0, 0.0), made->SetLowerLimit(0, 0.0);
      made->Init();
    }
    if (kind == "crane" && steps == 10) made->SetParam("fmax", 0, 50.0), made->SetParam("vel", 0, 1.0);
    if (kind == "crane" && steps > 90)
      std::cout << "crane " << made->Position(0) << " " << made->GetVelocity(0) << std::endl;
    if (kind == "weld" && steps == 50 && value > 0) made->Detach();
  }

  void Tell() {
    const auto link = model->GetLink("link");
    std::cout.precision(17);
    std::cout << "told " << steps << " " << model->GetWorld()->SimTime().Double() << " "
              << link->WorldPose().Pos().Z() << " " << link->WorldLinearVel().Z() << " "
              << (joint ? joint->Position(0) : 0.0) << " " << (joint ? joint->GetVelocity(0) : 0.0)
              << " " << model->BoundingBox().Max().Z() << std::endl;
  }

  physics::ModelPtr model;
  physics::JointPtr joint, slide, made;
  event::ConnectionPtr connection;
  std::unique_ptr<ros::NodeHandle> node;
  transport::NodePtr transport;
  transport::PublisherPtr factory;
  ros::Subscriber command;
  ros::Publisher position;
  std::string kind;
  double value = 0.0;
  int steps = 0;
};

GZ_REGISTER_MODEL_PLUGIN(Acting)

}  // namespace gazebo
