// The interface of gazebo_plugins that users' plugins read their parameters by.
//
// Same names, arguments, defaults and effects as upstream's header; this one has no library.
#ifndef GAZEBO_ROS_UTILS_H
#define GAZEBO_ROS_UTILS_H

#include <gazebo/common/common.hh>
#include <gazebo/gazebo_config.h>
#include <gazebo/physics/physics.hh>
#include <gazebo/sensors/Sensor.hh>
#include <ros/console.h>
#include <ros/ros.h>

#include <boost/algorithm/string.hpp>
#include <boost/lexical_cast.hpp>

#include <map>
#include <string>

#ifndef GAZEBO_SENSORS_USING_DYNAMIC_POINTER_CAST
#define GAZEBO_SENSORS_USING_DYNAMIC_POINTER_CAST using std::dynamic_pointer_cast
#endif

namespace gazebo {

// Name of the model that a sensor is in: world::MODEL::link::sensor.
inline std::string GetModelName(const sensors::SensorPtr &sensor) {
  const std::string name = sensor->ScopedName();
  const auto begin = name.find("::");
  if (begin == std::string::npos) return "";
  return name.substr(begin + 2, name.find("::", begin + 2) - begin - 2);
}

// <robotNamespace> of a sensor's plugin; an empty one is the model's name.
inline std::string GetRobotNamespace(
    const sensors::SensorPtr &sensor, const sdf::ElementPtr &sdf, const char *info = nullptr) {
  if (!sdf->HasElement("robotNamespace")) {
    if (info) ROS_INFO_NAMED("utils", "%s Plugin: there is no <robotNamespace>", info);
    return "";
  }
  const auto given = sdf->Get<std::string>("robotNamespace");
  const std::string result = given.empty() ? GetModelName(sensor) : given;
  if (info) ROS_INFO_NAMED("utils", "%s Plugin: namespace '%s'", info, result.c_str());
  return result;
}

// Node handle and parameters of a plugin.
class GazeboRos {
 public:
  // Of a model's plugin, whose namespace is the model's name where it gives none.
  GazeboRos(physics::ModelPtr &model, sdf::ElementPtr sdf, const std::string &plugin)
      : sdf_(sdf), plugin_(plugin) {
    if (sdf->HasElement("robotNamespace")) namespace_ = sdf->Get<std::string>("robotNamespace");
    if (namespace_.empty()) namespace_ = model->GetName();
    if (!namespace_.empty()) namespace_ += "/";
    start();
  }

  // Of a sensor's plugin, whose namespace is the root where it gives none.
  GazeboRos(sensors::SensorPtr sensor, sdf::ElementPtr sdf, const std::string &plugin)
      : sdf_(sdf), plugin_(plugin), namespace_(GetRobotNamespace(sensor, sdf)) {
    start();
  }

  const char *info() const { return info_.c_str(); }
  boost::shared_ptr<ros::NodeHandle> &node() { return node_; }
  const boost::shared_ptr<ros::NodeHandle> &node() const { return node_; }

  // The frame with the prefix of the parameter tf_prefix; as tf::resolve().
  std::string resolveTF(const std::string &name) {
    if (!name.empty() && name[0] == '/') return name.substr(1);
    if (prefix_.empty()) return name;
    return (prefix_[0] == '/' ? prefix_.substr(1) : prefix_) + "/" + name;
  }

  void getParameterBoolean(bool &value, const char *tag, const bool &otherwise) {
    value = otherwise;
    if (!sdf_->HasElement(tag)) {
      missing(tag, otherwise ? "true" : "false");
      return;
    }
    getParameterBoolean(value, tag);
  }

  void getParameterBoolean(bool &value, const char *tag) {
    if (!sdf_->HasElement(tag)) return;
    const auto text = boost::to_lower_copy(sdf_->GetElement(tag)->Get<std::string>());
    if (text == "true" || text == "1")
      value = true;
    else if (text == "false" || text == "0")
      value = false;
    else
      ROS_WARN_NAMED("utils", "%s: <%s> must be true or false, is '%s'", info(), tag, text.c_str());
  }

  // The joint that a tag names; throws where the model has none of the name.
  physics::JointPtr getJoint(
      physics::ModelPtr &model, const char *tag, const std::string &otherwise) {
    std::string name;
    getParameter<std::string>(name, tag, otherwise);
    const auto joint = model->GetJoint(name);
    if (!joint) gzthrow(info_ + ": the model has no joint '" + name + "'");
    return joint;
  }

  void isInitialized() {
    if (!ros::isInitialized()) ROS_FATAL_STREAM(info_ << ": roscpp is not initialized");
  }

  template <class T>
  void getParameter(T &value, const char *tag, const T &otherwise) {
    value = otherwise;
    if (sdf_->HasElement(tag))
      getParameter<T>(value, tag);
    else
      missing(tag, boost::lexical_cast<std::string>(otherwise));
  }

  template <class T>
  void getParameter(T &value, const char *tag) {
    if (sdf_->HasElement(tag)) value = sdf_->GetElement(tag)->Get<T>();
  }

  // The option whose key a tag has.
  template <class T>
  void getParameter(
      T &value, const char *tag, const std::map<std::string, T> &options, const T &otherwise) {
    value = otherwise;
    if (sdf_->HasElement(tag))
      getParameter<T>(value, tag, options);
    else
      missing(tag, boost::lexical_cast<std::string>(otherwise));
  }

  template <class T>
  void getParameter(T &value, const char *tag, const std::map<std::string, T> &options) {
    if (!sdf_->HasElement(tag)) return;
    const auto key = sdf_->GetElement(tag)->Get<std::string>();
    const auto found = options.find(key);
    if (found == options.end())
      ROS_WARN_NAMED("utils", "%s: <%s> has '%s', which is no option", info(), tag, key.c_str());
    else
      value = found->second;
  }

 private:
  void start() {
    node_.reset(new ros::NodeHandle(namespace_));
    info_ = plugin_ + "(ns = " + namespace_ + ")";
    const std::map<std::string, ros::console::Level> levels{
        {"debug", ros::console::levels::Debug}, {"info", ros::console::levels::Info},
        {"warn", ros::console::levels::Warn},   {"error", ros::console::levels::Error},
        {"fatal", ros::console::levels::Fatal}};
    std::string level;
    getParameter<std::string>(level, "rosDebugLevel");
    const auto found = levels.find(boost::to_lower_copy(level));
    if (found != levels.end() &&
        ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, found->second))
      ros::console::notifyLoggerLevelsChanged();
    std::string key;
    if (node_->searchParam("tf_prefix", key)) node_->getParam(key, prefix_);
  }

  void missing(const char *tag, const std::string &otherwise) const {
    ROS_WARN_NAMED("utils", "%s: missing <%s>, default is %s", info(), tag, otherwise.c_str());
  }

  sdf::ElementPtr sdf_;
  std::string plugin_, namespace_, prefix_, info_;
  boost::shared_ptr<ros::NodeHandle> node_;
};

typedef boost::shared_ptr<GazeboRos> GazeboRosPtr;

}  // namespace gazebo
#endif
