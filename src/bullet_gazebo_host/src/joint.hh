// A joint of Gazebo's whose state and motor are a row of the solver.
#pragma once
#include <map>

#include "link.hh"

namespace paddock {

class RowJoint : public gazebo::physics::Joint {
 public:
  explicit RowJoint(gazebo::physics::BasePtr parent);
  ~RowJoint() override { Fini(); }
  void Init() override;
  void Fini() override;
  void Attach(gazebo::physics::LinkPtr parent, gazebo::physics::LinkPtr child) override;
  void Detach() override;

  // Has it a row; one, two: rows of the bodies that it connects, -1: the world.
  void Bind(int row, int one, int two);
  void RefreshRate();  // after a velocity of one of its links was written

  gazebo::physics::LinkPtr GetJointLink(unsigned int index) const override;
  bool AreConnected(gazebo::physics::LinkPtr a, gazebo::physics::LinkPtr b) const override;
  void SetAxis(unsigned int index, const Vector3d &axis) override;
  Vector3d OwnAxis() const { return axis; }  // in its frame
  void SetAnchor(unsigned int, const Vector3d &) override {}
  Vector3d Anchor(unsigned int index) const override;
  Vector3d GlobalAxis(unsigned int index) const override;

  void SetDamping(unsigned int index, double damping) override;
  void SetStiffness(unsigned int index, double stiffness) override;
  void SetStiffnessDamping(
      unsigned int index, double stiffness, double damping, double reference) override;
  void SetVelocity(unsigned int index, double velocity) override;
  double GetVelocity(unsigned int index) const override;
  void SetForce(unsigned int index, double effort) override;
  double GetForce(unsigned int index) override;
  bool SetPosition(unsigned int index, double position, bool keeps_velocity) override;
  using Joint::SetPosition;
  gazebo::physics::JointWrench GetForceTorque(unsigned int index) override;
  Vector3d LinkForce(unsigned int index) const override;
  Vector3d LinkTorque(unsigned int index) const override;
  void SetLowerLimit(unsigned int index, double limit) override;
  void SetUpperLimit(unsigned int index, double limit) override;
  bool SetParam(const std::string &key, unsigned int index, const boost::any &value) override;
  double GetParam(const std::string &key, unsigned int index) override;
  void Reset() override;
  using Base::Reset;
  void CacheForceTorque() override { RefreshRate(); }  // Gazebo's own does nothing with ODE

 protected:
  double PositionImpl(unsigned int index) const override;

 private:
  bool HasRow() const { return row >= 0 && tables().joints; }
  double &At(Column name) const { return tables().Joint(row, name); }
  void WriteLimits();
  void Wake() const;
  // Column of a parameter by ODE's names; col::COLUMNS: there is none.
  static Column ColumnOf(const std::string &key);

  int row = -1, one = -1, two = -1;
  const int made;  // number of one that a plugin has made; 0: it is of a model's file
  bool is_ready = false;
  Vector3d axis{1, 0, 0};  // ODE's first
  std::map<Column, double> given;  // what was set before it had a row
  double applied = 0.0;
  gazebo::common::Time applied_at;
};

// What the solver has to do for a joint that a plugin has made.
struct JointChange {
  int number;  // of the joint
  bool attach;
};

// The next one; false: there is none.
bool nextChange(JointChange *change);

// Such a joint; null: it has gone.
boost::shared_ptr<RowJoint> madeJoint(int number);

// Whether joints that are made now are those of models that the solver has.
bool &isInserting();

// The joint of a type of SDF; null: there is none.
gazebo::physics::JointPtr makeJoint(const std::string &type, gazebo::physics::ModelPtr model);

}  // namespace paddock
