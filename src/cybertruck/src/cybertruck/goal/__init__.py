"""Go to a point: control laws, the controller and its node."""
