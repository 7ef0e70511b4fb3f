#include "link.hh"

#include <algorithm>
#include <cmath>

namespace paddock {
namespace {

std::vector<RowLink *> g_bound;
std::vector<gazebo::physics::ModelPtr> g_moved;

// Gazebo compares poses with a tolerance of 1e-3.
bool same(const Pose3d &one, const Pose3d &two) {
  for (int k = 0; k < 3; ++k)
    if (one.Pos()[k] != two.Pos()[k]) return false;
  const auto &a = one.Rot(), &b = two.Rot();
  return a.W() == b.W() && a.X() == b.X() && a.Y() == b.Y() && a.Z() == b.Z();
}

}  // namespace

Tables &tables() {
  static Tables instance;
  return instance;
}

int &Quiet::count() {
  static int instance = 0;
  return instance;
}

const std::vector<RowLink *> &boundLinks() { return g_bound; }

std::vector<gazebo::physics::ModelPtr> takeMoved() {
  std::vector<gazebo::physics::ModelPtr> result;
  result.swap(g_moved);
  return result;
}

void RowLink::Fini() {
  g_bound.erase(std::remove(g_bound.begin(), g_bound.end(), this), g_bound.end());
  row = -1;
  Link::Fini();
}

void RowLink::Bind(int number, const Pose3d &in_row, bool is_primary) {
  const bool is_bound = std::find(g_bound.begin(), g_bound.end(), this) != g_bound.end();
  row = number, frame = in_row, primary = is_primary;
  if (row >= 0 && !is_bound) g_bound.push_back(this);
}

void RowLink::Init() {
  Quiet quiet;  // the solver has it where it is
  Link::Init();
}

Pose3d RowLink::RowPose() const {
  const Quaterniond turn = getTurn(At(col::QUAT));
  return {get(At(col::POS)) + turn.RotateVector(frame.Pos()), turn * frame.Rot()};
}

void RowLink::Pull(bool now) {
  if (!HasRow()) return;
  const Pose3d pose = RowPose();
  if (same(pose, last)) return;
  last = pose;
  if (now) {
    Quiet quiet;
    SetWorldPose(pose, false);
  } else {
    dirtyPose = pose;
    world->_AddDirty(this);
  }
}

void RowLink::Forget() { last.Pos().X(std::nan("")); }

void RowLink::OnPoseChange() {
  Link::OnPoseChange();
  if (Quiet::count() > 0 || !initialized) return;
  if (!HasRow()) {
    const auto model = GetParentModel();
    if (std::find(g_moved.begin(), g_moved.end(), model) == g_moved.end())
      g_moved.push_back(model);
    return;
  }
  if (!primary) return;
  SetEnabled(true);
  const Pose3d pose = WorldPose();
  const Quaterniond turn = pose.Rot() * frame.Rot().Inverse();
  put(At(col::POS), pose.Pos() - turn.RotateVector(frame.Pos()));
  putTurn(At(col::QUAT), turn);
  last = RowPose();
}

void RowLink::UpdateMass() {
  if (!HasRow() || !inertial || kinematic) return;
  if (!primary || inertial->Mass() <= 0) {
    gzerr << "link " << GetScopedName() << " has the mass " << inertial->Mass()
          << " kg; must be above 0, of a link that is no part of another one\n";
    return;
  }
  const auto turn = frame.Rot().Inverse();
  const ignition::math::Matrix3d rotation(turn);
  const auto moments = rotation * inertial->MOI() * rotation.Transposed();
  const auto inverse = moments.Inverse();
  At(col::MASS)[0] = inertial->Mass();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      At(col::INERTIA)[3 * i + j] = moments(i, j), At(col::INVERSE)[3 * i + j] = inverse(i, j);
  SetEnabled(true);
}

void RowLink::SetEnabled(bool enable) const {
  if (!HasRow()) return;
  if (!enable) {
    At(col::ASLEEP)[0] = 1.0;  // it counts where the body may sleep
    return;
  }
  At(col::REST)[0] = tables().rest.time, At(col::REST_STEPS)[0] = tables().rest.steps;
  At(col::ASLEEP)[0] = 0.0;
}

bool RowLink::GetEnabled() const {
  return !HasRow() || At(col::MAY_SLEEP)[0] == 0.0 || At(col::ASLEEP)[0] == 0.0;
}

void RowLink::SetGravityMode(bool mode) {
  if (sdf->HasElement("gravity")) sdf->GetElement("gravity")->Set(mode);
  if (HasRow()) At(col::GRAVITY)[0] = mode, SetEnabled(true);
}

bool RowLink::GetGravityMode() const {
  return HasRow() ? At(col::GRAVITY)[0] != 0.0 : !IsStatic() && sdf->Get<bool>("gravity");
}

void RowLink::SetSelfCollide(bool collide) { sdf->GetElement("self_collide")->Set(collide); }

void RowLink::SetKinematic(const bool &state) {
  sdf->GetElement("kinematic")->Set(state);
  if (!HasRow() || state == kinematic) return;
  kinematic = state;
  if (!state) {
    UpdateMass();
    return;
  }
  At(col::MASS)[0] = tables().infinite;
  std::fill(At(col::INVERSE), At(col::INVERSE) + 9, 0.0);
}

void RowLink::SetLinearDamping(double damping) {
  if (HasRow()) At(col::DECAY)[0] = damping;
}

void RowLink::SetAngularDamping(double damping) {
  if (HasRow()) At(col::DECAY)[1] = damping;
}

void RowLink::SetAutoDisable(bool disable) {
  if (HasRow() && GetModel()->GetJointCount() == 0) At(col::MAY_SLEEP)[0] = disable;
}

void RowLink::Moved() {
  for (const auto &joints : {GetParentJoints(), GetChildJoints()})
    for (const auto &joint : joints) joint->CacheForceTorque();  // see RowJoint
}

void RowLink::SetLinearVel(const Vector3d &velocity) {
  if (!HasRow()) return;
  const Vector3d arm = WorldCoGPose().Pos() - get(At(col::POS));
  put(At(col::VEL), velocity - get(At(col::VEL) + 3).Cross(arm));
  Moved();
}

void RowLink::SetAngularVel(const Vector3d &velocity) {
  if (!HasRow()) return;
  put(At(col::VEL) + 3, velocity);
  Moved();
}

Vector3d RowLink::PointVelocity(const Vector3d &point) const {
  return get(At(col::VEL)) + get(At(col::VEL) + 3).Cross(point - get(At(col::POS)));
}

Vector3d RowLink::WorldLinearVel(const Vector3d &offset) const {
  if (!HasRow()) return {};
  const Pose3d &pose = WorldPose();
  return PointVelocity(pose.Pos() + pose.Rot().RotateVector(offset));
}

Vector3d RowLink::WorldLinearVel(const Vector3d &offset, const Quaterniond &turn) const {
  return HasRow() ? PointVelocity(WorldPose().Pos() + turn.RotateVector(offset)) : Vector3d();
}

Vector3d RowLink::WorldCoGLinearVel() const {
  return HasRow() ? PointVelocity(WorldCoGPose().Pos()) : Vector3d();
}

Vector3d RowLink::WorldAngularVel() const { return HasRow() ? get(At(col::VEL) + 3) : Vector3d(); }

void RowLink::NoteForces() {
  if (HasRow()) force = get(At(col::FORCE)), torque = get(At(col::FORCE) + 3);
}

void RowLink::SetForce(const Vector3d &value) {
  if (!HasRow()) return;
  SetEnabled(true);
  put(At(col::FORCE), value);
}

void RowLink::SetTorque(const Vector3d &value) {
  if (!HasRow()) return;
  SetEnabled(true);
  put(At(col::FORCE) + 3, value);
}

void RowLink::AddForce(const Vector3d &value) {
  AddForceAtWorldPosition(value, WorldCoGPose().Pos());
}

void RowLink::AddTorque(const Vector3d &value) {
  if (!HasRow()) return;
  SetEnabled(true);
  put(At(col::FORCE) + 3, get(At(col::FORCE) + 3) + value);
}

void RowLink::AddRelativeForce(const Vector3d &value) {
  AddForce(WorldPose().Rot().RotateVector(value));
}

void RowLink::AddRelativeTorque(const Vector3d &value) {
  AddTorque(WorldPose().Rot().RotateVector(value));
}

void RowLink::AddForceAtWorldPosition(const Vector3d &value, const Vector3d &point) {
  if (!HasRow()) return;
  AddTorque((point - get(At(col::POS))).Cross(value));
  put(At(col::FORCE), get(At(col::FORCE)) + value);
}

// ODE has the point relative to the center of mass, whatever Gazebo's header says.
void RowLink::AddForceAtRelativePosition(const Vector3d &value, const Vector3d &point) {
  const Pose3d center = WorldCoGPose();
  AddForceAtWorldPosition(value, center.Pos() + WorldPose().Rot().RotateVector(point));
}

void RowLink::AddLinkForce(const Vector3d &value, const Vector3d &offset) {
  const Pose3d &pose = WorldPose();
  const Vector3d point = pose.Pos() + pose.Rot().RotateVector(offset);
  AddForceAtWorldPosition(pose.Rot().RotateVector(value), point);
}

}  // namespace paddock
