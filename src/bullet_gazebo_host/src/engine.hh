// What the engine asks of its caller.
#pragma once

namespace paddock {

struct Engine {
  void (*step)() = nullptr;  // makes one step
  // Distance along a ray from a point (3) [m] along a vector (3) [m] to what it hits.
  double (*cast)(const double *from, const double *along) = nullptr;
  bool has_stepped = false, gravity_changed = false;
  bool is_open = false;  // the world is there: parameters are set by plugins
};

Engine &engine();

// Has every world that is made from now on steps by this engine.
void registerEngine();

}  // namespace paddock
