// The physics engine "ode" of Gazebo's World: rows of Paddock's solver, which makes the steps.
#include "engine.hh"

#include <gazebo/common/common.hh>
#include <gazebo/physics/PhysicsFactory.hh>

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

// A ray asks the solver's scene.
class Ray : public RayShape {
 public:
  using RayShape::RayShape;
  void Update() override {}
  void GetIntersection(double &distance, std::string &entity) override {
    const Vector3d from = globalStartPos, along = globalEndPos - globalStartPos;
    const double start[] = {from.X(), from.Y(), from.Z()};
    const double reach[] = {along.X(), along.Y(), along.Z()};
    distance = engine().cast ? engine().cast(start, reach) : 1000.0;
    entity.clear();
  }
};

class RowPhysics : public PhysicsEngine {
 public:
  explicit RowPhysics(WorldPtr world) : PhysicsEngine(world) {}
  void Init() override {}
  void InitForThread() override {}
  void UpdateCollision() override {}
  void SetSeed(uint32_t) override {}
  void DebugPrint() const override {}
  std::string GetType() const override { return "ode"; }

  void UpdatePhysics() override {
    boost::recursive_mutex::scoped_lock lock(*GetPhysicsUpdateMutex());
    if (!engine().step) return;
    for (RowLink *link : boundLinks()) link->NoteForces();
    engine().has_stepped = true;
    engine().step();
    for (RowLink *link : boundLinks()) link->Pull(false);
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
    if (type == "ray" && collision) return ShapePtr(new Ray(collision));
    if (type == "ray") return ShapePtr(new Ray(world->Physics()));
    gzerr << "a collision has the shape " << type
          << ", known here are box, sphere, cylinder, plane and ray\n";
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
