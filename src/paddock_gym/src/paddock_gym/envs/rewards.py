"""The reward `progress`."""

from paddock_gym.course import LAP, RUNNING, RunState

PER_METER = 1.0
FAILURE = -3.0  # for a run that ended before its lap


def progress(state: RunState) -> float:
    """Meters along the course since the last action, and a penalty for a run that failed."""
    failed = state.end not in (RUNNING, LAP)
    return PER_METER * state.gain + (FAILURE if failed else 0.0)
