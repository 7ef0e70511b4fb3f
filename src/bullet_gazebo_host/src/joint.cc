#include "joint.hh"

#include <cmath>
#include <deque>
#include <mutex>

namespace paddock {

using gazebo::physics::JointPtr;
using gazebo::physics::JointWrench;
using gazebo::physics::LinkPtr;
using gazebo::physics::ModelPtr;

namespace {

constexpr double UNLIMITED = 1e16;  // SDF's limit of a joint that has none

int g_made = 0;  // joints that plugins have made
std::map<int, boost::weak_ptr<gazebo::physics::Base>> g_joints;
std::deque<JointChange> g_changes;
std::mutex g_mutex;  // plugins make joints in threads of ROS, too

void noRow(const RowJoint &joint, const char *what) {
  gzerr << "joint " << joint.GetScopedName() << ": " << what << " has no effect\n";
}

void demand(int number, bool attach) {
  std::lock_guard<std::mutex> lock(g_mutex);
  g_changes.push_back({number, attach});
}

}  // namespace

bool &isInserting() {
  static bool instance = false;
  return instance;
}

bool nextChange(JointChange *change) {
  std::lock_guard<std::mutex> lock(g_mutex);
  if (g_changes.empty()) return false;
  *change = g_changes.front();
  g_changes.pop_front();
  return true;
}

boost::shared_ptr<RowJoint> madeJoint(int number) {
  std::lock_guard<std::mutex> lock(g_mutex);
  const auto found = g_joints.find(number);
  return boost::dynamic_pointer_cast<RowJoint>(
      found == g_joints.end() ? nullptr : found->second.lock());
}

RowJoint::RowJoint(gazebo::physics::BasePtr parent)
    : Joint(parent), made(isInserting() ? 0 : ++g_made) {}

void RowJoint::Init() {
  Joint::Init();
  if (made == 0) return;
  {
    std::lock_guard<std::mutex> lock(g_mutex);
    g_joints[made] = shared_from_this();
  }
  is_ready = true;
  demand(made, true);
}

void RowJoint::Fini() {
  if (is_ready) demand(made, false);
  is_ready = false;
  row = -1;
  Joint::Fini();
}

void RowJoint::Attach(LinkPtr parent, LinkPtr child) {
  Joint::Attach(parent, child);
  if (is_ready) demand(made, true);
}

void RowJoint::Detach() {
  Joint::Detach();
  if (made == 0 && HasRow()) noRow(*this, "Detach() of a joint of the model's file");
  if (is_ready) demand(made, false), row = -1;
}

void RowJoint::Bind(int index, int first, int second) {
  row = index, one = first, two = second;
  if (!HasRow()) return;
  for (const auto &each : given) At(each.first) = each.second;
  given.clear();
}

void RowJoint::SetAxis(unsigned int index, const Vector3d &value) {
  if (index == 0 && value.Length() > 0.0) axis = value.Normalized();
}

void RowJoint::RefreshRate() {
  if (HasRow() && DOF() > 0) At(col::RATE) = GetVelocity(0);
}

void RowJoint::Wake() const {
  for (const auto &link : {childLink, parentLink})
    if (link) link->SetEnabled(true);
}

LinkPtr RowJoint::GetJointLink(unsigned int index) const {
  return index == 0 ? childLink : index == 1 ? parentLink : LinkPtr();
}

bool RowJoint::AreConnected(LinkPtr a, LinkPtr b) const {
  return (a == parentLink && b == childLink) || (a == childLink && b == parentLink);
}

Vector3d RowJoint::Anchor(unsigned int) const { return WorldPose().Pos(); }

Vector3d RowJoint::GlobalAxis(unsigned int) const {
  if (HasRow() && one >= 0)
    return getTurn(tables().Body(one, col::QUAT)).RotateVector(get(&At(col::AXIS1)));
  return WorldPose().Rot().RotateVector(LocalAxis(0));
}

double RowJoint::GetVelocity(unsigned int) const {
  if (!HasRow()) return 0.0;
  const int shift = HasType(SLIDER_JOINT) ? 0 : 3;
  Vector3d relative = get(tables().Body(one, col::VEL) + shift);
  if (two >= 0) relative -= get(tables().Body(two, col::VEL) + shift);
  return GlobalAxis(0).Dot(relative);
}

double RowJoint::PositionImpl(unsigned int) const { return HasRow() ? At(col::ANGLE) : 0.0; }

void RowJoint::SetVelocity(unsigned int index, double velocity) {
  if (!HasRow()) return;
  SetVelocityMaximal(index, velocity);
  RefreshRate();
}

bool RowJoint::SetPosition(unsigned int index, double position, bool keeps_velocity) {
  if (!HasRow()) return false;
  const double before = At(col::ANGLE);
  if (!SetPositionMaximal(index, position, keeps_velocity)) return false;
  const double lower = LowerLimit(index), upper = UpperLimit(index);
  const double reached = std::min(std::max(position, lower), std::max(lower, upper));
  At(col::ANGLE) = At(col::REACHED) = reached;
  if (reached != before) Wake();
  return true;
}

void RowJoint::SetForce(unsigned int index, double effort) {
  if (!HasRow()) {
    if (made == 0) noRow(*this, "SetForce() of a joint that is not simulated");
    return;
  }
  effort = CheckAndTruncateForce(index, effort);
  const auto now = GetWorld()->SimTime();
  if (applied_at < now) applied_at = now, applied = 0.0;
  applied += effort;
  At(col::EFFORT) += effort;
  Wake();
}

double RowJoint::GetForce(unsigned int) { return applied; }

void RowJoint::SetDamping(unsigned int index, double damping) {
  SetStiffnessDamping(index, stiffnessCoefficient[index], damping, 0.0);
}

void RowJoint::SetStiffness(unsigned int index, double stiffness) {
  SetStiffnessDamping(index, stiffness, dissipationCoefficient[index], 0.0);
}

void RowJoint::SetStiffnessDamping(
    unsigned int index, double stiffness, double damping, double reference) {
  if (index >= DOF()) {
    gzerr << "joint " << GetScopedName() << " has " << DOF() << " axes, none of number " << index
          << "\n";
    return;
  }
  stiffnessCoefficient[index] = stiffness, dissipationCoefficient[index] = damping;
  springReferencePosition[index] = reference;
  if (!HasRow()) return;
  At(col::DAMPING) = std::abs(damping), At(col::STIFFNESS) = stiffness, At(col::AT_REST) = reference;
}

void RowJoint::WriteLimits() {
  if (!HasRow()) return;
  const double lower = LowerLimit(0), upper = UpperLimit(0);
  const bool is_free = lower <= -UNLIMITED && upper >= UNLIMITED;
  At(col::LOWER) = is_free ? 1.0 : lower, At(col::UPPER) = is_free ? -1.0 : upper;
  Wake();
}

void RowJoint::SetLowerLimit(unsigned int index, double limit) {
  Joint::SetLowerLimit(index, limit);
  WriteLimits();
}

void RowJoint::SetUpperLimit(unsigned int index, double limit) {
  Joint::SetUpperLimit(index, limit);
  WriteLimits();
}

Column RowJoint::ColumnOf(const std::string &key) {
  static const std::map<std::string, Column> columns{
      {"fmax", col::FMAX}, {"friction", col::FMAX}, {"vel", col::SPEED}, {"erp", col::ERP}, {"cfm", col::CFM},
      {"stop_erp", col::STOP_ERP}, {"stop_cfm", col::STOP_CFM}, {"fudge_factor", col::STOP_PUSH},
      {"hi_stop", col::UPPER}, {"lo_stop", col::LOWER}, {"thread_pitch", col::PITCH}};
  const auto found = columns.find(key);
  return found == columns.end() ? col::COLUMNS : found->second;
}

bool RowJoint::SetParam(
    const std::string &key, unsigned int index, const boost::any &value) {
  const Column column = ColumnOf(key);
  if (column == col::COLUMNS) {
    gzerr << "Unable to handle joint attribute[" << key << "]\n";
    return false;
  }
  const double *number = boost::any_cast<double>(&value);  // as ODE's: no other type
  if (!number) {
    gzerr << "SetParam(" << key << ") of joint " << GetScopedName() << " got a "
          << value.type().name() << ", must be a double\n";
    return false;
  }
  if (!HasRow()) {  // of a joint of a file the solver has what that says
    if (column == col::UPPER || column == col::LOWER)
      column == col::UPPER ? SetUpperLimit(index, *number) : SetLowerLimit(index, *number);
    else if (made != 0)
      given[column] = *number;
    return true;
  }
  Wake();
  if (column == col::UPPER || column == col::LOWER) {
    if (At(col::LOWER) > At(col::UPPER)) At(col::LOWER) = -UNLIMITED, At(col::UPPER) = UNLIMITED;
    At(column) = *number;
    return true;
  }
  At(column) = *number;
  if (key == "vel" || key == "friction") At(col::TARGET) = At(col::IMPOSED) = std::nan("");
  if (key == "friction") At(col::SPEED) = 0.0;
  return true;
}

double RowJoint::GetParam(const std::string &key, unsigned int index) {
  const Column column = ColumnOf(key);
  if (column == col::COLUMNS) {
    gzerr << "Unable to get joint attribute[" << key << "]\n";
    return 0.0;
  }
  if (!HasRow()) return 0.0;
  if (At(col::LOWER) > At(col::UPPER) && column == col::LOWER) return LowerLimit(index);
  if (At(col::LOWER) > At(col::UPPER) && column == col::UPPER) return UpperLimit(index);
  const double value = At(column);
  if ((column == col::ERP || column == col::CFM) && value < 0.0)
    return boost::any_cast<double>(GetWorld()->Physics()->GetParam(key));
  return value;
}

void RowJoint::Reset() {
  applied_at = gazebo::common::Time::Zero;
  Joint::Reset();
}

Vector3d RowJoint::LinkForce(unsigned int index) const {
  const Vector3d force = HasRow() ? get(&At(col::WRENCH)) : Vector3d();
  return index == 0 ? force : -force;
}

Vector3d RowJoint::LinkTorque(unsigned int index) const {
  const Vector3d torque = HasRow() ? get(&At(col::WRENCH) + 3) : Vector3d();
  if (index == 0 || two < 0 || !HasRow()) return index == 0 ? torque : -torque;
  // The same wrench about the other center of mass.
  const Vector3d arm = get(tables().Body(one, col::POS)) - get(tables().Body(two, col::POS));
  return -(torque + arm.Cross(LinkForce(0)));
}

// Force and torque about the joint: of the parent on the child in the child's axes with a minus, of
// the child on the parent in the parent's; what SetForce() applied counts for neither.
JointWrench RowJoint::GetForceTorque(unsigned int) {
  JointWrench result;
  if (!HasRow() || one < 0) return result;
  const Vector3d force = LinkForce(0);
  const Vector3d arm = get(tables().Body(one, col::POS)) - WorldPose().Pos();
  const Vector3d torque = LinkTorque(0) + arm.Cross(force);
  const auto in = [](const LinkPtr &link, const Vector3d &vector) {
    return link ? link->WorldPose().Rot().RotateVectorReverse(vector) : vector;
  };
  result.body2Force = in(childLink, -force), result.body2Torque = in(childLink, -torque);
  result.body1Force = in(parentLink, force), result.body1Torque = in(parentLink, torque);
  const Vector3d own = GetForce(0) * LocalAxis(0);
  if (HasType(HINGE_JOINT)) result.body2Torque -= own, result.body1Torque += own;
  if (HasType(SLIDER_JOINT)) result.body2Force -= own, result.body1Force += own;
  return result;
}

JointPtr makeJoint(const std::string &type, ModelPtr model) {
  using namespace gazebo::physics;
  if (type == "revolute") return JointPtr(new HingeJoint<RowJoint>(model));
  if (type == "prismatic") return JointPtr(new SliderJoint<RowJoint>(model));
  if (type == "fixed") return JointPtr(new FixedJoint<RowJoint>(model));
  return {};
}

}  // namespace paddock
