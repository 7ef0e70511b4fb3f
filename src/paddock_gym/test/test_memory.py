"""Memory stays where it is, however long an environment is used."""

import gymnasium
import psutil

import paddock_gym

WARM_UP, ACTIONS, ROUNDS = 300, 900, 5
MAX_GROWTH = 0.5e6  # [bytes] of growth; 550 an action would be 110 MB in a training of 200,000


def test_actions_and_resets_leave_no_memory_behind():
    env = gymnasium.make(paddock_gym.IDS[0])
    env.action_space.seed(0)
    env.reset(seed=0)
    drive(env, WARM_UP)
    memory, grown = psutil.Process().memory_info, []
    while not grown or grown[-1] >= MAX_GROWTH and len(grown) < ROUNDS:  # a leak is in each round
        before = memory().rss
        assert drive(env, ACTIONS) > 20
        grown.append(memory().rss - before)
    env.close()
    assert grown[-1] < MAX_GROWTH, grown


def drive(env, actions):
    """Take random actions; returns how many runs ended."""
    runs = 0
    for _ in range(actions):
        *_, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            env.reset()
            runs += 1
    return runs
