#include <gazebo/common/common.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/sensors/sensors.hh>

#include <cstdio>

namespace gazebo {

// A model's plugin that looks for a sensor by its name.
class ActingSeeker : public ModelPlugin {
 public:
  void Load(physics::ModelPtr model, sdf::ElementPtr sdf) override {
    const auto name = sdf->Get<std::string>("sensor");
    const auto found = sensors::SensorManager::Instance()->GetSensor(name);
    printf("found %d\n", bool(found));
    if (!found) return;
    found->SetActive(true);
    connection = found->ConnectUpdated([found] {
      const auto ray = std::dynamic_pointer_cast<sensors::RaySensor>(found);
      printf("sought %.6f %.9g\n", ray->LastMeasurementTime().Double(), ray->Range(0));
      fflush(stdout);
    });
  }

 private:
  event::ConnectionPtr connection;
};

GZ_REGISTER_MODEL_PLUGIN(ActingSeeker)
}  // namespace gazebo
