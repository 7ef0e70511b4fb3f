"""Parameters of the bridge node, read once."""

import math
from dataclasses import dataclass

RENDERERS = ("auto", "egl", "tiny")


@dataclass(frozen=True)
class Config:
    """Checked parameters.

    Attributes:
        world_file: SDF world to load; empty: an empty world.
        paused: start with simulated time standing still.
        real_time_factor: simulated seconds per wall second; 0: as fast as possible; None: as the
            world file says.
        lockstep: start paused; time advances only by /gazebo/step, with every picture.
        renderer: auto, egl or tiny.
        clock_rate: messages on /clock per simulated second [Hz].
        states_rate: of model_states and link_states in simulated time [Hz].
        seed: of all sensor noise.
        monotonic_clock: simulated time goes on in a reset instead of starting at 0.
        step_timeout: wall time that a step waits for its commands [s].
        gui, headless: gui without headless opens the viewer.
    """

    world_file: str = ""
    paused: bool = False
    real_time_factor: float | None = None
    lockstep: bool = False
    renderer: str = "auto"
    clock_rate: float = 200.0
    states_rate: float = 100.0
    seed: int = 0
    monotonic_clock: bool = False
    step_timeout: float = 10.0
    gui: bool = False
    headless: bool = False


def parse_config(get):
    """Config from a function get(name, default).

    Raises:
        ValueError: names the parameter, the value and what is valid.
    """
    given = get("real_time_factor", None) is not None
    factor = _number(get, "real_time_factor", None) if given else None
    if given and factor < 0:
        raise ValueError(
            f"parameter real_time_factor is {factor}, must be 0 (as fast as possible) or more"
        )
    rate = _number(get, "pub_clock_frequency", 200.0) or 200.0
    if rate < 0:
        raise ValueError(f"parameter pub_clock_frequency is {rate}, must be above 0 [Hz]")
    timeout = _number(get, "step_timeout", 10.0)
    if timeout < 0:
        raise ValueError(f"parameter step_timeout is {timeout}, must be 0 or more [s]")
    states_rate = _number(get, "pub_states_frequency", 100.0)
    if states_rate <= 0:
        raise ValueError(f"parameter pub_states_frequency is {states_rate}, must be above 0 [Hz]")
    renderer = get("renderer", "auto")
    if renderer not in RENDERERS:
        raise ValueError(
            f"parameter renderer is '{renderer}', must be one of {', '.join(RENDERERS)}"
        )
    lockstep = _flag(get, "lockstep")
    return Config(
        world_file=str(get("world_file", "")),
        paused=_flag(get, "paused") or lockstep,
        real_time_factor=factor,
        lockstep=lockstep,
        renderer=renderer,
        clock_rate=rate,
        states_rate=states_rate,
        seed=int(_number(get, "seed", 0)),
        monotonic_clock=_flag(get, "monotonic_clock"),
        step_timeout=timeout,
        gui=_flag(get, "gui"),
        headless=_flag(get, "headless"),
    )


def _number(get, name, default):
    value = get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(f"parameter {name} is {value!r}, must be a finite number")
    return float(value)


def _flag(get, name):
    value = get(name, False)
    if not isinstance(value, bool):
        raise ValueError(f"parameter {name} is {value!r}, must be true or false")
    return value
