// What the engine asks of its caller.
#pragma once

namespace paddock {

struct Engine {
  void (*step)() = nullptr;  // makes one step
  // Distances (count) [m] from a point (3) [m] along unit vectors (count x 3) to what they hit, from
  // `near` to `far` on; infinity: nothing, minus infinity: something nearer.
  void (*cast)(const double *from, const double *along, int count, double near, double far,
               double *distances) = nullptr;
  void (*contacts)() = nullptr;       // adds those of the step, by paddock_add_contacts()
  void (*update_sensors)() = nullptr;  // after a step; null: there are none
  void (*remove_sensors)(const char *model) = nullptr;
  bool is_stepping = false, has_stepped = false, gravity_changed = false;
  bool is_open = false;  // the world is there: parameters are set by plugins
};

Engine &engine();

// Has every world that is made from now on steps by this engine.
void registerEngine();

}  // namespace paddock
