"""Reward: head where the next waypoints lead."""

import math

AHEAD = 4  # waypoints


def reward_function(params):
    """The cosine of the angle between the car's heading and the path ahead, times the speed."""
    waypoints, ahead = params["waypoints"], params["closest_waypoints"][1]
    x, y = waypoints[(ahead + AHEAD) % (len(waypoints) - 1)]
    wanted = math.atan2(y - params["y"], x - params["x"])
    error = wanted - math.radians(params["heading"])
    if params["is_offtrack"]:
        return 1e-3
    return float(max(1e-3, math.cos(error)) * params["speed"])
