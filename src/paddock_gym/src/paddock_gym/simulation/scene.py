"""A track with one or several cars in a world of the core, stepped action by action."""

from bullet_sim.pose import Pose
from bullet_sim.world import World
from track_model.referee.course import Course
from track_model.referee.projector import Projector
from track_model.track import load_track

from paddock_gym.errors import GymError
from paddock_gym.simulation import description
from paddock_gym.simulation.car import Car
from paddock_gym.simulation.painter import Painter

SETTLING = 1.0  # simulated time until the cars stand still [s]
# Of a shape's radius, see Engine.set_contact_breaking: circles and speeds agree with those of
# PyBullet's own 0.02 to four digits, at 1.3 to 3 times its pace.
CONTACT_BREAKING = 0.002
REFERENCE_STEP = 0.001  # physics step at which the engine's position gain is meant [s]
SHORTEST_STEP, LONGEST_STEP = 0.0001, 0.005  # [s]
RATES = (1.0, 100.0)  # of control [Hz]
WINDOW = 0.5  # around the last place that is searched; an action takes a car less far [m]


class Scene:
    """A track with cars.

    Args:
        track: name or path of a track.
        time_step: physics step [s]; the nearest that divides the control period is taken.
        control_rate: actions per simulated second [Hz].
        cars: how many; they pass through each other.
        walls: see description.track_sdf.

    Attributes:
        track: track_model.track.Track.
        projector: Projector of its lane.
        world: bullet_sim.world.World.
        cars: list of Car.
        substeps: physics steps of an action.
        period: of control [s].

    Raises:
        GymError, TrackError: an option is wrong.
    """

    def __init__(self, track="default", time_step=1 / 240, control_rate=15.0, cars=1, walls=None):
        _check("time_step", time_step, SHORTEST_STEP, LONGEST_STEP, "s")
        _check("control_rate", control_rate, *RATES, "Hz")
        self.track = load_track(track)
        self.projector = Projector(Course(self.track.lane), WINDOW)
        self.period = 1.0 / control_rate
        self.substeps = max(1, round(self.period / time_step))
        self.world = World(self.period / self.substeps)
        self.world.scene = description.light()
        engine = self.world.engine
        engine.set_contact_breaking(CONTACT_BREAKING)
        engine.position_gain = 1.0 - (1.0 - engine.position_gain) ** (
            self.world.time_step / REFERENCE_STEP
        )
        sdf = description.track_sdf(self.track, walls)
        ground = self.world.spawn_sdf("track", sdf, Pose(), description.resolve)
        self.ground = frozenset({(ground.body, ground.link_in_body("ground")[0])})
        self.has_walls = "walls" in ground.link_names
        self.cars = [
            Car(self.world, f"car{number}", Pose((0.0, 0.0, 0.0)), description.car_urdf())
            for number in range(cars)
        ]
        if cars > 1:
            for car in self.cars:
                car.model.make_ghost()
        self.world.step(round(SETTLING / self.world.time_step))
        for car in self.cars:
            car.settled()
        self._rested = self._painter = None

    def restore(self):
        """Go back to the state of the first start, to the bit; place the cars then."""
        if self._rested is None:
            self._rested = self.world.engine.save_state()
        self.world.engine.restore_state(self._rested)
        self.world.step_count = 0

    def advance(self, substeps=None):
        """Advance by one action, or by some physics steps."""
        self.world.step(self.substeps if substeps is None else substeps)

    @property
    def painter(self):
        """Painter of the world, made when it is first asked for."""
        if self._painter is None:
            self._painter = Painter(self.world)
        return self._painter

    def close(self):
        """Free engine and renderer."""
        if self._painter is not None:
            self._painter.close()
            self._painter = None
        self.world.close()


def _check(name, value, low, high, unit):
    if not (isinstance(value, (int, float)) and low <= value <= high):
        raise GymError(f"{name} is {value!r}; it must be from {low:g} to {high:g} [{unit}]")
