"""Memory stays where it is over 100,000 actions of the state environment, with its resets."""

import sys
from pathlib import Path

import gymnasium
import psutil
import pytest

import paddock_gym

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src" / "paddock_gym" / "test"))
from test_memory import drive  # noqa: E402

WARM_UP, ACTIONS, SAMPLES = 10_000, 90_000, 9
MAX_GROWTH = 0.5e6  # [bytes] of growth after the warm-up: 6 for an action, 70 for a run


@pytest.mark.timeout(1200)  # 67 physics steps an action
def test_100000_actions_leave_no_memory_behind():
    env = gymnasium.make(paddock_gym.IDS[0])
    env.action_space.seed(0)
    env.reset(seed=0)
    drive(env, WARM_UP)
    memory = [psutil.Process().memory_info().rss]
    runs = 0
    for _ in range(SAMPLES):
        runs += drive(env, ACTIONS // SAMPLES)
        memory.append(psutil.Process().memory_info().rss)
    env.close()
    told = ", ".join(f"{one / 1e6:.2f}" for one in memory)
    print(f"{WARM_UP + ACTIONS} actions, {runs} runs, memory [MB]: {told}")
    assert runs > 2500
    assert memory[-1] - memory[0] < MAX_GROWTH, f"memory [MB] after {WARM_UP} actions: {told}"
