"""Parameters of the bridge node, read once."""

from dataclasses import dataclass, replace

from bullet_sim.render.request import RENDERERS, SWITCHES
from paddock_common.settings import check, choice, flag, number, read, text


@dataclass(frozen=True)
class Config:
    """Checked parameters.

    Attributes:
        world_file: SDF world to load; empty: an empty world.
        paused: start paused.
        real_time_factor: simulated seconds per wall second; 0: as fast as possible.
        world_pace: no real_time_factor is given; that of the world file counts.
        lockstep: start paused; time advances only by /gazebo/step, which waits for all pictures.
        every_picture: wait for each due picture, without lockstep, too; time slows down instead.
        renderer: auto, gl or tiny.
        shadows, antialias: auto, true or false: see bullet_sim.render.request.Quality.
        labels: every camera also publishes which model each pixel shows.
        clock_rate: messages on /clock per simulated second [Hz].
        states_rate: of model_states and link_states in simulated time [Hz].
        seed: of all sensor noise.
        monotonic_clock: a reset does not set simulated time back to 0.
        step_timeout: wall time that /gazebo/step waits for commands [s].
        gui, headless: gui without headless opens the viewer.
    """

    world_file: str = text("", empty=True)
    paused: bool = flag(False)
    real_time_factor: float = number(1.0, least=0.0)
    world_pace: bool = False
    lockstep: bool = flag(False)
    every_picture: bool = flag(False)
    renderer: str = choice("auto", RENDERERS)
    shadows: str = choice("auto", SWITCHES)
    antialias: str = choice("auto", SWITCHES)
    labels: bool = flag(False)
    clock_rate: float = number(200.0, least=0.0, unit="Hz", name="pub_clock_frequency")
    states_rate: float = number(100.0, above=0.0, unit="Hz", name="pub_states_frequency")
    seed: int = number(0)
    monotonic_clock: bool = flag(False)
    step_timeout: float = number(10.0, least=0.0, unit="s")
    gui: bool = flag(False)
    headless: bool = flag(False)

    def __post_init__(self):
        check(self, prefix="parameter ")


def parse_config(get):
    """Config from a function get(name, default).

    Raises:
        ValueError: names the parameter, the value and what is valid.
    """
    config = read(Config, get, prefix="")
    return replace(
        config,
        world_pace=get("real_time_factor", None) is None,
        paused=config.paused or config.lockstep,
        clock_rate=config.clock_rate or Config.clock_rate,  # 0: the default
        seed=int(config.seed),
    )
