// A joint of Gazebo's whose state and motor are a row of the solver.
#pragma once
#include "link.hh"

namespace paddock {

class RowJoint : public gazebo::physics::Joint {
 public:
  explicit RowJoint(gazebo::physics::BasePtr parent) : Joint(parent) {}
  ~RowJoint() override { Fini(); }
  void Fini() override;

  // Has it a row; one, two: rows of the bodies that it connects, -1: the world.
  void Bind(int row, int one, int two);
  void RefreshRate();  // after a velocity of one of its links was written

  gazebo::physics::LinkPtr GetJointLink(unsigned int index) const override;
  bool AreConnected(gazebo::physics::LinkPtr a, gazebo::physics::LinkPtr b) const override;
  void SetAxis(unsigned int, const Vector3d &) override {}
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
  double applied = 0.0;
  gazebo::common::Time applied_at;
};

// The joint of a type of SDF; null: there is none.
gazebo::physics::JointPtr makeJoint(const std::string &type, gazebo::physics::ModelPtr model);

}  // namespace paddock
