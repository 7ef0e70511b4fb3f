// The physics engine "ode" of Gazebo's World: rows of Paddock's solver, which makes the steps.
#include "engine.hh"

#include <gazebo/common/common.hh>
#include <gazebo/physics/PhysicsFactory.hh>
#include <gazebo/transport/transport.hh>

#include <cmath>

#include "joint.hh"

namespace paddock {

using namespace gazebo::physics;

namespace {

class RowCollision : public Collision {
 public:
  explicit RowCollision(LinkPtr link) : Collision(link) { surface.reset(new SurfaceParams); }
  void OnPoseChange() override {}
  void SetCategoryBits(unsigned int) override {}
  void SetCollideBits(unsigned int) override {}

  ignition::math::AxisAlignedBox BoundingBox() const override {
    const Vector3d half = 0.5 * Size();
    const Pose3d pose = WorldPose();
    const ignition::math::Matrix3d turn(pose.Rot());
    Vector3d reach;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) reach[i] += std::abs(turn(i, j)) * half[j];
    return {pose.Pos() - reach, pose.Pos() + reach};
  }

 private:
  // Edges of a box around it, along its own axes [m].
  Vector3d Size() const {
    if (const auto box = dynamic_cast<const BoxShape *>(shape.get())) return box->Size();
    if (const auto sphere = dynamic_cast<const SphereShape *>(shape.get()))
      return 2.0 * sphere->GetRadius() * Vector3d::One;
    if (const auto cylinder = dynamic_cast<const CylinderShape *>(shape.get())) {
      const double width = 2.0 * cylinder->GetRadius();
      return {width, width, cylinder->GetLength()};
    }
    return {};
  }
};

constexpr double FARTHEST = 1000.0;  // [m] which a ray tells that hits nothing

// Distances along unit vectors to what they hit; see Engine::cast.
std::vector<double> cast(
    const Vector3d &from, const std::vector<double> &along, double near, double far) {
  std::vector<double> distances(along.size() / 3, INFINITY);
  const double start[] = {from.X(), from.Y(), from.Z()};
  if (engine().cast && !distances.empty())
    engine().cast(start, along.data(), distances.size(), near, far, distances.data());
  return distances;
}

// A ray asks the solver's scene.
class SceneRay : public RayShape {
 public:
  using RayShape::RayShape;

  void Update() override {
    const Pose3d pose = collisionParent ? collisionParent->GetLink()->WorldPose() : Pose3d::Zero;
    globalStartPos = pose.CoordPositionAdd(relativeStartPos);
    globalEndPos = pose.CoordPositionAdd(relativeEndPos);
  }

  void GetIntersection(double &distance, std::string &entity) override {
    entity.clear();
    distance = FARTHEST;
    const Vector3d along = globalEndPos - globalStartPos;
    const double length = along.Length();
    if (!(length > 0.0) || !std::isfinite(length)) return;
    const Vector3d unit = along / length;
    const double found = cast(globalStartPos, {unit.X(), unit.Y(), unit.Z()}, 0.0, length)[0];
    if (std::isfinite(found)) distance = found;
  }
};

// Rays of a lidar, whose points are in the axes of its link.
class Scan : public MultiRayShape {
 public:
  using MultiRayShape::MultiRayShape;

  void AddRay(const Vector3d &start, const Vector3d &end) override {
    MultiRayShape::AddRay(start, end);
    const RayShapePtr ray(new SceneRay(collisionParent));
    ray->SetPoints(start, end);
    rays.push_back(ray);
  }

  void UpdateRays() override {
    const Pose3d pose = collisionParent->GetLink()->WorldPose();
    const double near = GetMinRange(), far = GetMaxRange();
    std::vector<double> along;
    bool together = true;  // all begin on a sphere around the sensor
    for (const auto &ray : rays) {
      Vector3d start, end;
      ray->RelativePoints(start, end);
      const Vector3d unit = (end - start).Normalized(), turned = pose.Rot().RotateVector(unit);
      along.insert(along.end(), {turned.X(), turned.Y(), turned.Z()});
      together = together && (start - unit * near - offset.Pos()).Length() < 1e-9;
    }
    if (together) {
      SetLengths(cast(pose.CoordPositionAdd(offset.Pos()), along, near, far), near);
      return;
    }
    std::vector<double> lengths;
    for (size_t i = 0; i < rays.size(); ++i) {
      Vector3d start, end;
      rays[i]->GlobalPoints(start, end);
      lengths.push_back(cast(start, {&along[3 * i], &along[3 * i] + 3}, 0.0, far - near)[0]);
    }
    SetLengths(lengths, 0.0);
  }

 private:
  void SetLengths(const std::vector<double> &distances, double near) {
    for (size_t i = 0; i < rays.size(); ++i)
      if (distances[i] < INFINITY) rays[i]->SetLength(std::max(0.0, distances[i] - near));
  }
};

class RowPhysics : public PhysicsEngine {
 public:
  explicit RowPhysics(WorldPtr world) : PhysicsEngine(world) {}
  void Init() override {}
  void InitForThread() override {}
  void UpdateCollision() override { contactManager->ResetCount(); }
  void SetSeed(uint32_t) override {}
  void DebugPrint() const override {}
  std::string GetType() const override { return "ode"; }

  void UpdatePhysics() override {
    boost::recursive_mutex::scoped_lock lock(*GetPhysicsUpdateMutex());
    if (!engine().is_stepping) return;
    for (RowLink *link : boundLinks()) link->NoteForces();
    engine().has_stepped = true;
    engine().step();
    for (RowLink *link : boundLinks()) link->Pull(false);
    if (engine().contacts && IsContactWanted()) engine().contacts();
  }

  // Whether somebody is told of contacts; as ODE's, which leaves them out otherwise.
  bool IsContactWanted() const {
    return contactManager->NeverDropContacts() || contactManager->contactPub->HasConnections() ||
           !contactManager->customContactPublishers.empty();
  }

  LinkPtr CreateLink(ModelPtr model) override {
    LinkPtr link(new RowLink(model));
    link->SetWorld(world);
    return link;
  }

  CollisionPtr CreateCollision(const std::string &type, LinkPtr link) override {
    CollisionPtr collision(new RowCollision(link));
    const ShapePtr shape = CreateShape(type, collision);
    collision->SetShape(shape);
    if (shape) shape->SetWorld(world);
    return collision;
  }

  ShapePtr CreateShape(const std::string &type, CollisionPtr collision) override {
    if (type == "box") return ShapePtr(new BoxShape(collision));
    if (type == "sphere") return ShapePtr(new SphereShape(collision));
    if (type == "cylinder") return ShapePtr(new CylinderShape(collision));
    if (type == "plane") return ShapePtr(new PlaneShape(collision));
    if (type == "multiray") return ShapePtr(new Scan(collision));
    if (type == "ray" && collision) return ShapePtr(new SceneRay(collision));
    if (type == "ray") return ShapePtr(new SceneRay(world->Physics()));
    gzerr << "a collision has the shape " << type
          << ", known here are box, sphere, cylinder, plane, ray and multiray\n";
    return {};
  }

  JointPtr CreateJoint(const std::string &type, ModelPtr model) override {
    const JointPtr joint = makeJoint(type, model);
    if (!joint)
      gzthrow("joint type " + type + " is not known here; known are revolute, prismatic, fixed");
    joint->SetWorld(world);
    return joint;
  }

  void SetGravity(const Vector3d &gravity) override {
    world->SetGravitySDF(gravity);
    engine().gravity_changed = true;
  }

  boost::any GetParam(const std::string &key) const override {
    boost::any value;
    GetParam(key, value);
    return value;
  }

  bool GetParam(const std::string &key, boost::any &value) const override {
    const auto ode = sdf->GetElement("ode");
    const auto solver = ode->GetElement("solver"), limits = ode->GetElement("constraints");
    if (key == "iters" || key == "precon_iters")
      value = solver->Get<int>(key);
    else if (key == "sor")
      value = solver->Get<double>(key);
    else if (key == "cfm" || key == "erp" || key == "contact_max_correcting_vel" ||
             key == "contact_surface_layer")
      value = limits->Get<double>(key);
    else if (key == "solver_type")
      value = solver->Get<std::string>("type");
    else
      return PhysicsEngine::GetParam(key, value);
    return true;
  }

  bool SetParam(const std::string &key, const boost::any &value) override {
    if (key == "gravity" || key == "magnetic_field" || !engine().is_open)
      return engine().is_open ? PhysicsEngine::SetParam(key, value) : true;
    gzerr << "parameter " << key << " of the physics stays as it is: here the world file and "
          << "/gazebo/set_physics_properties change it, not a plugin\n";
    return false;
  }
};

PhysicsEnginePtr make(WorldPtr world) { return PhysicsEnginePtr(new RowPhysics(world)); }

}  // namespace

Engine &engine() {
  static Engine instance;
  return instance;
}

void registerEngine() { PhysicsFactory::RegisterPhysicsEngine("ode", make); }

}  // namespace paddock

// Gazebo's libraries that were built without ODE ask for it by this name.
GZ_PHYSICS_VISIBLE void RegisterODEPhysics() { paddock::registerEngine(); }
