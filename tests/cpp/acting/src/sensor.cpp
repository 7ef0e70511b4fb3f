// Plugins of sensors, by <kind>: they print what the sensor tells, at each of its updates.
#include <gazebo/common/common.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/sensors/sensors.hh>

#include <cstdio>

namespace gazebo {

class ActingSensor : public SensorPlugin {
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr sdf) override {
    if (sdf->HasElement("throw")) throw std::runtime_error("no lens");
    sensor->SetActive(true);
    connection = sensor->ConnectUpdated([this, sensor] { Tell(sensor); });
  }

 private:
  static void Print(const sensors::SensorPtr &sensor, const std::vector<double> &numbers) {
    printf("%s %.6f", sensor->Name().c_str(), sensor->LastMeasurementTime().Double());
    for (double number : numbers) printf(" %.9g", number);
    printf("\n");
    fflush(stdout);
  }

  void Tell(const sensors::SensorPtr &sensor) {
    if (auto ray = std::dynamic_pointer_cast<sensors::RaySensor>(sensor)) {
      std::vector<double> ranges;
      ray->Ranges(ranges);
      Print(sensor, ranges);
    } else if (auto imu = std::dynamic_pointer_cast<sensors::ImuSensor>(sensor)) {
      const auto a = imu->LinearAcceleration(), w = imu->AngularVelocity();
      Print(sensor, {a.X(), a.Y(), a.Z(), w.X(), w.Y(), w.Z(), imu->Orientation().W()});
    } else if (auto contact = std::dynamic_pointer_cast<sensors::ContactSensor>(sensor)) {
      const auto all = contact->Contacts();
      double force = 0.0, back = 0.0;
      for (const auto &each : all.contact())
        for (const auto &wrench : each.wrench()) {
          force += wrench.body_1_wrench().force().z();
          back += wrench.body_2_wrench().force().z();
        }
      Print(sensor, {double(all.contact_size()), force, back});
    } else if (auto wrench = std::dynamic_pointer_cast<sensors::ForceTorqueSensor>(sensor)) {
      const auto force = wrench->Force(), torque = wrench->Torque();
      Print(sensor, {force.X(), force.Y(), force.Z(), torque.X(), torque.Y(), torque.Z()});
    } else if (auto gps = std::dynamic_pointer_cast<sensors::GpsSensor>(sensor)) {
      Print(sensor, {gps->Latitude().Degree(), gps->Longitude().Degree(), gps->Altitude()});
    } else if (auto altimeter = std::dynamic_pointer_cast<sensors::AltimeterSensor>(sensor)) {
      Print(sensor, {altimeter->Altitude(), altimeter->VerticalVelocity()});
    } else if (auto magnetic = std::dynamic_pointer_cast<sensors::MagnetometerSensor>(sensor)) {
      const auto field = magnetic->MagneticField();
      Print(sensor, {field.X(), field.Y(), field.Z()});
    } else if (auto sonar = std::dynamic_pointer_cast<sensors::SonarSensor>(sensor)) {
      Print(sensor, {sonar->Range()});
    }
  }

  event::ConnectionPtr connection;
};

GZ_REGISTER_SENSOR_PLUGIN(ActingSensor)
}  // namespace gazebo
