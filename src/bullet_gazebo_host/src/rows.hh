// Rows of the solver's tables: where links and joints read and write their state.
//
// Units and axes are those of bullet_sim/engine/quickstep/layout.py: m, kg, s, rad; world axes;
// quaternions are (x, y, z, w). The caller gives the columns by the names below, so that the layout
// is written down once.
#pragma once
#include <ignition/math/Pose3.hh>
#include <ignition/math/Vector3.hh>

namespace paddock {

#define PADDOCK_BODY_COLUMNS(X) \
  X(POS) X(QUAT) X(VEL) X(REST) X(REST_STEPS) X(ASLEEP) X(MASS) X(INERTIA) X(INVERSE) X(GRAVITY) \
  X(MAY_SLEEP) X(FORCE) X(DECAY) X(B_SIZE)
#define PADDOCK_JOINT_COLUMNS(X) \
  X(AXIS1) X(LOWER) X(UPPER) X(DAMPING) X(FMAX) X(SPEED) X(EFFORT) X(ANGLE) X(RATE) X(TARGET) \
  X(REACHED) X(WRENCH) X(IMPOSED) X(STOP_ERP) X(STOP_CFM) X(STOP_PUSH) X(STIFFNESS) X(AT_REST) \
  X(ERP) X(CFM) X(PITCH) X(J_SIZE)

struct col {
  enum Column {
#define X(name) name,
    PADDOCK_BODY_COLUMNS(X) PADDOCK_JOINT_COLUMNS(X)
#undef X
    COLUMNS
  };
};
using Column = col::Column;

// Rest after which a body sleeps, as it is written where it is woken.
struct Rest {
  double time = 0.0, steps = 0.0;  // [s], steps
};

// The solver's tables; null while there are none.
struct Tables {
  double *bodies = nullptr, *joints = nullptr;
  int column[col::COLUMNS] = {};
  Rest rest;
  double infinite = 0.0;  // mass of what forces do not move [kg]

  double *Body(int row, Column name) const {
    return bodies + row * column[col::B_SIZE] + column[name];
  }
  double &Joint(int row, Column name) const {
    return joints[row * column[col::J_SIZE] + column[name]];
  }
};

Tables &tables();

inline ignition::math::Vector3d get(const double *from) { return {from[0], from[1], from[2]}; }

inline void put(double *to, const ignition::math::Vector3d &value) {
  to[0] = value.X(), to[1] = value.Y(), to[2] = value.Z();
}

inline ignition::math::Quaterniond getTurn(const double *from) {
  return {from[3], from[0], from[1], from[2]};
}

inline void putTurn(double *to, const ignition::math::Quaterniond &value) {
  to[0] = value.X(), to[1] = value.Y(), to[2] = value.Z(), to[3] = value.W();
}

}  // namespace paddock
