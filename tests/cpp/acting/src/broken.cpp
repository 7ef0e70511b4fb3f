// Its library lacks a symbol.
#include <gazebo/gazebo.hh>

namespace gazebo {

class Nowhere {
 public:
  Nowhere();
  virtual ~Nowhere();
};

class Broken : public ModelPlugin {
 public:
  void Load(physics::ModelPtr, sdf::ElementPtr) override {}

 private:
  Nowhere nowhere;
};

GZ_REGISTER_MODEL_PLUGIN(Broken)

}  // namespace gazebo
