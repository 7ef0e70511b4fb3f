// A plugin that reads its parameters and publishes as gazebo_plugins' own do.
#include <gazebo/common/common.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo_plugins/PubQueue.h>
#include <gazebo_plugins/gazebo_ros_utils.h>
#include <std_msgs/String.h>

namespace gazebo {

class ActingUtils : public ModelPlugin {
 public:
  void Load(physics::ModelPtr model, sdf::ElementPtr sdf) override {
    ros_.reset(new GazeboRos(model, sdf, "utils"));
    ros_->isInitialized();
    double given = 0.0, missing = 0.0;
    bool flag = false;
    int option = 0;
    ros_->getParameter<double>(given, "given", 1.0);
    ros_->getParameter<double>(missing, "missing", 2.5);
    ros_->getParameterBoolean(flag, "flag", false);
    ros_->getParameter<int>(option, "option", {{"one", 1}, {"two", 2}}, 0);
    std::string joint = "a joint";
    try {
      ros_->getJoint(model, "joint", "none");
    } catch (const common::Exception &) {
      joint = "no joint";
    }
    message_.data = std::to_string(given) + " " + std::to_string(missing) + " " +
                    std::to_string(flag) + " " + std::to_string(option) + " " + joint + " " +
                    ros_->resolveTF("/base") + " " + ros_->info();
    publisher_ = ros_->node()->advertise<std_msgs::String>("said", 1, true);
    queue_ = queues_.addPub<std_msgs::String>();
    queues_.startServiceThread();
    queue_->push(message_, publisher_);
  }

 private:
  GazeboRosPtr ros_;
  PubMultiQueue queues_;
  PubQueue<std_msgs::String>::Ptr queue_;
  std_msgs::String message_;
  ros::Publisher publisher_;
};

GZ_REGISTER_MODEL_PLUGIN(ActingUtils)
}  // namespace gazebo
