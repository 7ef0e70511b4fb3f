// Publishes how many steps the world has made, and what models there are.
#include <ros/ros.h>
#include <std_msgs/String.h>

#include <gazebo/common/common.hh>
#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>

namespace gazebo {

class Counting : public WorldPlugin {
 public:
  void Load(physics::WorldPtr world, sdf::ElementPtr) override {
    this->world = world;
    publisher = node.advertise<std_msgs::String>("/models", 1);
    connection = event::Events::ConnectWorldUpdateEnd([this] { Publish(); });
  }

 private:
  void Publish() {
    std_msgs::String message;
    for (const auto &model : world->Models()) message.data += model->GetName() + " ";
    publisher.publish(message);
  }

  physics::WorldPtr world;
  ros::NodeHandle node;
  ros::Publisher publisher;
  event::ConnectionPtr connection;
};

GZ_REGISTER_WORLD_PLUGIN(Counting)

}  // namespace gazebo
