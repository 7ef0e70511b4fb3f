// A link of Gazebo's whose body is a row of the solver.
#pragma once
#include <gazebo/physics/physics.hh>

#include "rows.hh"

namespace paddock {

using ignition::math::Pose3d;
using ignition::math::Quaterniond;
using ignition::math::Vector3d;

class RowLink : public gazebo::physics::Link {
 public:
  explicit RowLink(gazebo::physics::EntityPtr parent) : Link(parent) {}
  ~RowLink() override { Fini(); }
  void Fini() override;

  // Has it a body: row of the solver, pose of the link's frame in that of the body (whose origin is
  // the center of mass). Several links may share one; only a primary one moves it by its pose.
  void Bind(int row, const Pose3d &frame, bool primary);
  int Row() const { return row; }
  void Pull(bool now);  // takes the body's pose over: at once, or after the step as Gazebo does
  void Forget();        // the pose is taken over by the next Pull()
  void Moved();         // its velocity was written: its joints' velocities follow

  void Init() override;
  void OnPoseChange() override;
  void UpdateMass() override;
  void SetEnabled(bool enable) const override;
  bool GetEnabled() const override;
  void SetGravityMode(bool mode) override;
  bool GetGravityMode() const override;
  void SetSelfCollide(bool collide) override;
  void SetKinematic(const bool &state) override;
  bool GetKinematic() const override { return kinematic; }
  void SetLinearDamping(double damping) override;
  void SetAngularDamping(double damping) override;
  void SetAutoDisable(bool disable) override;
  void SetLinkStatic(bool) override {}  // ODE's does nothing either

  void SetLinearVel(const Vector3d &velocity) override;
  void SetAngularVel(const Vector3d &velocity) override;
  Vector3d WorldLinearVel(const Vector3d &offset) const override;
  Vector3d WorldLinearVel(const Vector3d &offset, const Quaterniond &frame) const override;
  using Link::WorldLinearVel;
  Vector3d WorldCoGLinearVel() const override;
  Vector3d WorldAngularVel() const override;

  void SetForce(const Vector3d &force) override;
  void SetTorque(const Vector3d &torque) override;
  void AddForce(const Vector3d &force) override;
  void AddTorque(const Vector3d &torque) override;
  void AddRelativeForce(const Vector3d &force) override;
  void AddRelativeTorque(const Vector3d &torque) override;
  void AddForceAtWorldPosition(const Vector3d &force, const Vector3d &point) override;
  void AddForceAtRelativePosition(const Vector3d &force, const Vector3d &point) override;
  void AddLinkForce(const Vector3d &force, const Vector3d &offset) override;
  Vector3d WorldForce() const override { return force; }
  Vector3d WorldTorque() const override { return torque; }
  void NoteForces();  // before a step: what acts in it

 private:
  bool HasRow() const { return row >= 0 && tables().bodies; }
  double *At(Column name) const { return tables().Body(row, name); }
  Pose3d RowPose() const;
  Vector3d PointVelocity(const Vector3d &point) const;  // of a point in the world

  int row = -1;
  Pose3d frame, last;  // last: the pose that the row and the link had in common
  bool primary = false, kinematic = false;
  Vector3d force, torque;
};

// All links that have a row, in the order of Bind().
const std::vector<RowLink *> &boundLinks();

// Models without a row that a plugin has moved since the last call.
std::vector<gazebo::physics::ModelPtr> takeMoved();

// While it lives poses are taken over from the solver and not written to it.
struct Quiet {
  Quiet() { ++count(); }
  ~Quiet() { --count(); }
  static int &count();
};

}  // namespace paddock
