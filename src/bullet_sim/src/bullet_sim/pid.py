"""PID gains as ros_control's configuration files spell them."""

import math
from dataclasses import dataclass

from bullet_sim.errors import ControllerError

KEYS = ('p', 'i', 'd', 'i_clamp', 'i_clamp_max', 'i_clamp_min', 'antiwindup',
        'publish_state')


@dataclass(frozen=True)
class PidGains:
    """Gains and the bounds of the integral term's contribution."""

    p: float
    i: float = 0.0
    d: float = 0.0
    i_clamp_min: float = 0.0
    i_clamp_max: float = 0.0
    antiwindup: bool = False


def parse_pid(values, what):
    """Check a `pid` mapping.

    Args:
        values: mapping with p, i, d, and i_clamp or i_clamp_min and i_clamp_max.
        what: name for messages.

    Raises:
        ControllerError: not a mapping, unknown key, not a finite number, no p.
    """
    if not isinstance(values, dict):
        raise ControllerError(f'{what} pid is {values!r}, must be a mapping with p, i, d')
    unknown = sorted(set(values) - set(KEYS), key=str)
    if unknown:
        raise ControllerError(f"{what} pid has key '{unknown[0]}', known are {', '.join(KEYS)}")
    if 'p' not in values:
        raise ControllerError(f'{what} pid has no p')
    numbers = {}
    for key in KEYS[:6]:
        value = values.get(key, 0.0)
        if isinstance(value, bool) or not isinstance(value, (int, float)) \
                or not math.isfinite(value):
            raise ControllerError(f'{what} pid {key} is {value!r}, must be a finite number')
        numbers[key] = float(value)
    clamp = abs(numbers['i_clamp'])
    return PidGains(numbers['p'], numbers['i'], numbers['d'],
                    -abs(numbers['i_clamp_min']) or -clamp, abs(numbers['i_clamp_max']) or clamp,
                    bool(values.get('antiwindup', False)))
