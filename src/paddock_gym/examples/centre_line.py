"""Reward: stay near the center line, drive fast, steer calmly."""

CALM = 15.0  # steering below which nothing is taken off [degrees]
FAST = 2.0  # [m/s]


def reward_function(params):
    """The closer to the centerline and the faster, the more."""
    if not params["all_wheels_on_track"] or params["is_reversed"]:
        return 1e-3
    ratio = params["distance_from_center"] / (0.5 * params["track_width"])
    reward = max(0.0, 1.0 - ratio**2)
    reward *= min(1.0, params["speed"] / FAST)
    if abs(params["steering_angle"]) > CALM:
        reward *= 0.8
    return float(reward)
