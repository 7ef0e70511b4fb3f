"""What every car of the bench does: a circle. Wheels turn, hinges stand at an angle."""

WHEELS = [f"{side}_{end}_wheel" for side in ("left", "right") for end in ("rear", "front")]
HINGES = [f"{side}_steering_hinge" for side in ("left", "right")]
SPEED, ANGLE = 20.0, 0.25  # of the wheels [rad/s], of the hinges [rad]
WHEEL_RADIUS = 0.03  # [m]
COMMANDS = [(f"{name}_velocity_controller", SPEED) for name in WHEELS] + [
    (f"{name}_position_controller", ANGLE) for name in HINGES
]
