"""Reward: progress per action, and a bonus for a full lap in few actions."""

EXPECTED = 200  # actions of a good lap


def reward_function(params):
    """Progress over actions, so that a fast car gets more for the same distance."""
    if params["is_offtrack"]:
        return 1e-3
    reward = params["progress"] / max(params["steps"], 1)
    if params["progress"] == 100.0:
        reward += 10.0 * max(0.1, EXPECTED / params["steps"])
    return float(reward)
