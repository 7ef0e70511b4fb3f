"""How a model moves: bases that follow a Twist, joint states, transforms."""
