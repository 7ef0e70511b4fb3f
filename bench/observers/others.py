"""others NAME: one environment of ../others.py, in the Python in which it is installed.

Needs nothing of the bench. Says once, as JSON, what a step of it is; then for each line on stdin
(seconds) steps that long and says how many steps a second that were, and how many a second of
processor time of all its threads.
"""

import json
import math
import os
import sys
import tempfile
import time

WARM_UP = 2.0  # [s] before anything is measured, after the first step, in which numba compiles


class Paddock:
    """The DeepRacer round a ring, one car or several, each in its world."""

    radius, width, speed, wheelbase = 2.0, 1.4, 1.5, 0.164  # [m], [m], [m/s], [m]

    def __init__(self, observation, cars):
        import gymnasium
        import numpy as np
        from paddock_gym.contract.actions import Continuous

        import paddock_gym

        angles = [2.0 * math.pi * k / 24 for k in range(24)]
        points = [
            [round(self.radius * math.sin(t), 4), round(-self.radius * math.cos(t), 4)]
            for t in angles
        ]
        options = {"observation": observation, "randomize": (), "walls": observation == "lidar"}
        with tempfile.TemporaryDirectory() as folder:
            options["track"] = os.path.join(folder, "ring.yaml")
            with open(options["track"], "w") as stream:
                stream.write(f"points: {points}\nwidth: {self.width}\n")
            name = paddock_gym.IDS[0]
            if cars == 1:
                self.env = gymnasium.make(name, **options)
            else:
                self.env = gymnasium.make_vec(
                    name, num_envs=cars, vectorization_mode="vector_entry_point", **options
                )
        action = Continuous().action(self.speed, math.atan(self.wheelbase / self.radius))
        self._action, self._many, self.cars = action, cars > 1, cars
        if self._many:
            self._action = np.tile(action, (cars, 1))  # cars that end start again by themselves
        one = (self.env.envs[0] if self._many else self.env).unwrapped
        self.period, self.time_step = one.period, one.world.world.time_step
        self.env.reset(seed=0)

    def step(self):
        """One action."""
        _, _, terminated, truncated, _ = self.env.step(self._action)
        if not self._many and (terminated or truncated):
            self.env.reset()


class F1tenth:
    """f1tenth_gym v1.0.0 round a ring with walls; agents see and hit each other."""

    radius, width, speed = 6.0, 3.0, 2.0  # [m], [m], [m/s]
    wheelbase, resolution = 0.33, 0.05  # [m]
    longest = 400  # steps between resets

    def __init__(self, cars):
        import gymnasium
        import numpy as np
        from f1tenth_gym.envs.track import Track

        angles = np.linspace(0.0, 2.0 * math.pi, 100, endpoint=False)  # it closes the line itself
        x, y = self.radius * np.cos(angles), self.radius * np.sin(angles)
        track = Track.from_refline(x, y, np.full_like(x, self.speed))
        rows, columns = track.occupancy_map.shape
        left, low, _ = track.spec.origin
        distance = np.hypot(
            left + self.resolution * np.arange(columns)[None, :],
            low + self.resolution * np.arange(rows)[:, None],
        )
        track.occupancy_map[np.abs(distance - self.radius) > self.width / 2] = 0.0
        config = {"map": track, "num_agents": cars, "observation_config": {"type": "original"}}
        self.env = gymnasium.make("f1tenth_gym:f1tenth-v0", config=config)
        at = 2.0 * math.pi * np.arange(cars) / cars
        place = (self.radius * np.cos(at), self.radius * np.sin(at), at + math.pi / 2.0)
        self._start = {"poses": np.stack(place, axis=1)}
        steering = math.atan(self.wheelbase / self.radius)
        self._action = np.tile((steering, self.speed), (cars, 1))
        self.cars, self._count = cars, 0
        self.period = self.time_step = self.env.unwrapped.timestep
        self.env.reset(options=self._start)

    def step(self):
        """One step of 10 ms, with a scan for each agent."""
        _, _, terminated, truncated, _ = self.env.step(self._action)
        self._count += 1
        if terminated or truncated or self._count % self.longest == 0:
            self.env.reset(options=self._start)


class CarRacing:
    """Gymnasium's CarRacing-v3, its image as the observation."""

    longest = 400  # steps between resets

    def __init__(self):
        import gymnasium
        import numpy as np

        self.env = gymnasium.make("CarRacing-v3")
        self._action, self.cars, self._count = np.array((0.0, 0.1, 0.0), np.float32), 1, 0
        self.period = self.time_step = 1.0 / self.env.metadata["render_fps"]
        self.env.reset(seed=0)

    def step(self):
        """One step of 20 ms, with its image."""
        _, _, terminated, truncated, _ = self.env.step(self._action)
        self._count += 1
        if terminated or truncated or self._count % self.longest == 0:
            self.env.reset(seed=0)


class Racecar:
    """racecar_gym on PyBullet round a ring with walls, by its scenario's API: one or more agents.

    It has to be a checkout that is installed with -e: its models stand beside the package. Its
    tracks come from the web; this ring is a scene of the same form, with walls of boxes.
    """

    radius, width, boxes = 6.0, 3.0, 64  # [m], [m], of a wall
    resolution, half = 0.05, 16.0  # of the maps [m]: a pixel, and from the center to the border
    steering, speed = -0.265, 0.05  # what makes the circle at 2 m/s, of -1 to 1
    longest = 400  # steps between resets

    def __init__(self, cars):
        import racecar_gym.bullet.providers as providers
        import racecar_gym.envs.gym_api as api

        self._folder = tempfile.TemporaryDirectory()
        root = self._folder.name
        for folder in ("models/scenes/ring", "package/bullet"):
            os.makedirs(os.path.join(root, folder))
        models = os.path.join(providers.base_path, "..", "..", "models", "vehicles")
        os.symlink(os.path.realpath(models), os.path.join(root, "models", "vehicles"))
        providers.base_path = os.path.join(root, "package", "bullet")  # models beside the scene
        self._write_scene(os.path.join(root, "models", "scenes", "ring"))
        scenario = os.path.join(root, "scenario.yml")
        self._names = [f"car{number}" for number in range(cars)]
        with open(scenario, "w") as stream:
            json.dump(
                {"world": {"name": "ring"}, "agents": list(map(self._agent, self._names))}, stream
            )
        kind = api.SingleAgentRaceEnv if cars == 1 else api.MultiAgentRaceEnv
        self.env = kind(scenario, render_mode="rgb_array_follow")  # no window; nothing is rendered
        action = {"steering": self.steering, "speed": self.speed}
        self._action = action if cars == 1 else {name: dict(action) for name in self._names}
        self.cars, self._count, self.period = cars, 0, 0.01
        self.time_step = self.period
        self._reset()

    @staticmethod
    def _agent(name):
        sensors = ["lidar", "pose", "velocity", "acceleration"]  # of its examples
        vehicle = {"name": "racecar", "sensors": sensors, "actuators": ["steering", "speed"]}
        task = {"laps": 1000, "time_limit": 1e6, "terminate_on_collision": False}
        return {
            "id": name,
            "vehicle": vehicle,
            "task": {"task_name": "maximize_progress", "params": task},
        }

    def _write_scene(self, folder):
        import numpy as np

        at = np.arange(-self.half, self.half, self.resolution)
        x, y = np.meshgrid(at, -at)
        free = self.width / 2.0 - np.abs(np.hypot(x, y) - self.radius)
        np.savez(
            os.path.join(folder, "maps.npz"),
            norm_distance_from_start=np.arctan2(y, x) % (2.0 * math.pi) / (2.0 * math.pi),
            norm_distance_to_obstacle=np.maximum(free, 0.0) / (self.width / 2.0),
            drivable_area=free > 0.0,
        )
        np.savez(os.path.join(folder, "grid.npz"), data=np.zeros((16, 2)))
        walls = "\n".join(  # PyBullet reads lines of 8 kB at most
            self._box(2.0 * math.pi * (number + 0.5) / self.boxes, radius)
            for radius in (self.radius - self.width / 2.0, self.radius + self.width / 2.0)
            for number in range(self.boxes)
        )
        plane = "<geometry><plane><normal>0 0 1</normal><size>40 40</size></plane></geometry>"
        floor = f'<link name="link"><collision name="c">{plane}</collision></link>'
        text = "\n".join(
            f'<model name="{name}"><static>1</static>{link}</model>'
            for name, link in (("floor", floor), ("walls", f'<link name="link">{walls}</link>'))
        )
        with open(os.path.join(folder, "ring.sdf"), "w") as stream:
            stream.write(f'<sdf version="1.6"><world name="ring">{text}</world></sdf>')
        table = {
            "name": "ring",
            "sdf": "ring.sdf",
            "map": {
                "resolution": self.resolution,
                "origin": [-self.half, -self.half],
                "maps": "maps.npz",
                "starting_grid": "grid.npz",
                "checkpoints": 20,
            },
            "physics": {"gravity": -9.81},
            "simulation": {"time_step": 0.01, "rendering": False},
        }
        with open(os.path.join(folder, "ring.yml"), "w") as stream:
            json.dump(table, stream)

    def _box(self, angle, radius):
        length = 2.1 * math.pi * radius / self.boxes
        place = f"{radius * math.cos(angle)} {radius * math.sin(angle)} 0.25 0 0 {angle}"
        shape = f"<geometry><box><size>0.05 {length} 0.5</size></box></geometry>"
        return f'<collision name="c{angle}{radius}"><pose>{place}</pose>{shape}</collision>'

    def _reset(self):
        self.env.reset(options={"mode": "grid"})
        agents = self.env.scenario.world._agents
        for number, agent in enumerate(agents):
            at = 2.0 * math.pi * number / self.cars
            place = (self.radius * math.cos(at), self.radius * math.sin(at), 0.05)
            agent.reset((place, (0.0, 0.0, at + math.pi / 2.0)))

    def step(self):
        """One step of 10 ms, with the sensors that are due."""
        self.env.step(self._action)
        self._count += 1
        if self._count % self.longest == 0:
            self._reset()


class Mujoco:
    """MuJoCo's rollout of a car with the DeepRacer's masses and joints on a plane.

    A step is the 67 physics steps of an action of Paddock; states come back, nothing else.
    """

    steps, time_step = 67, 0.001  # of an action; [s]
    speed, wheel_radius, turn = 1.5, 0.03, 0.0895  # [m/s], [m], steering of both hinges [rad]

    def __init__(self, cars):
        import mujoco
        import numpy as np
        from mujoco import rollout

        self._model = mujoco.MjModel.from_xml_string(mujoco_car(self.time_step))
        threads = min(cars, len(os.sched_getaffinity(0)))
        self._data = [mujoco.MjData(self._model) for _ in range(threads)]
        self._rollout = rollout.Rollout(nthread=threads if threads > 1 else 0)
        kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
        state = np.empty(mujoco.mj_stateSize(self._model, kind))
        mujoco.mj_getState(self._model, self._data[0], state, kind)
        self._state = np.tile(state, (cars, 1))
        control = [self.turn] * 2 + [self.speed / self.wheel_radius] * 4
        self._control = np.tile(control, (cars, self.steps, 1))
        self.cars, self.period = cars, self.steps * self.time_step

    def step(self):
        """One rollout from where the last one ended."""
        states, _ = self._rollout.rollout(self._model, self._data, self._state, self._control)
        self._state = states[:, -1]


def mujoco_car(time_step):
    """MJCF text of the car: chassis, two hinges, four wheels of the URDF's masses and friction."""
    wheel = (
        '<inertial pos="0 0 0" mass="0.042222" diaginertia="6.11771e-5 9.44606e-5 6.11771e-5"/>'
        '<joint name="{0}" axis="0 1 0"/>'
        '<geom type="cylinder" size="0.03 0.002" euler="90 0 0" friction="0.5" priority="1"/>'
    )
    hinge = (
        '<body pos="0.082311 {1} 0.011759">'
        '<inertial pos="0 0 0" mass="0.05" diaginertia="1e-5 1e-5 1e-5"/>'
        '<joint name="{0}_hinge" axis="0 0 1" range="-60 60" damping="0.02"/>'
        "<body>" + wheel.format("{0}_front") + "</body></body>"
    )
    rear = '<body pos="-0.081663 {1} 0.01575">' + wheel.format("{0}_rear") + "</body>"
    body, actuators = "", ""
    for side, sign in (("left", 1.0), ("right", -1.0)):
        body += hinge.format(side, sign * 0.079601) + rear.format(side, sign * 0.08105)
        actuators += f'<position joint="{side}_hinge" kp="1"/>'
    for name in ("left_rear", "left_front", "right_rear", "right_front"):
        actuators += f'<velocity joint="{name}" kv="0.02" forcerange="-10 10"/>'
    return f"""<mujoco>
<option timestep="{time_step}"/>
<worldbody>
<geom type="plane" size="50 50 1" friction="1"/>
<body pos="0 0 0.0163"><freejoint/>
<inertial pos="0 0 0" mass="1.9068" diaginertia="0.004151895 0.010379737 0.010379737"/>
<geom type="box" pos="0.0125 0 0.034" size="0.1425 0.045 0.03" friction="0.2"/>
<geom type="box" pos="-0.005 0 0.072" size="0.115 0.075 0.018" friction="0.2"/>
{body}
</body>
</worldbody>
<actuator>{actuators}</actuator>
</mujoco>"""


KINDS = {
    "paddock_state_1": lambda: Paddock("state", 1),
    "paddock_state_16": lambda: Paddock("state", 16),
    "paddock_lidar_1": lambda: Paddock("lidar", 1),
    "paddock_lidar_16": lambda: Paddock("lidar", 16),
    "f1tenth_1": lambda: F1tenth(1),
    "f1tenth_16": lambda: F1tenth(16),
    "racecar_1": lambda: Racecar(1),
    "racecar_16": lambda: Racecar(16),
    "mujoco_1": lambda: Mujoco(1),
    "mujoco_16": lambda: Mujoco(16),
    "car_racing": CarRacing,
}


def main(name):
    """Serve rounds until stdin ends; what libraries print goes to stderr."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # PyBullet prints past Python
    subject = KINDS[name]()
    subject.step()
    rate(subject, WARM_UP)
    about = {key: getattr(subject, key) for key in ("period", "time_step", "cars")}
    print(json.dumps(about), file=answers, flush=True)
    for line in sys.stdin:
        every, own = rate(subject, float(line))
        print(json.dumps({"rate": every, "own": own}), file=answers, flush=True)


def rate(subject, seconds):
    """Steps over a round of at least one step: a second, and a second of processor time.

    Args:
        subject: of KINDS.
        seconds: wall time of the round.
    """
    begin, spent, done, passed = time.monotonic(), time.process_time(), 0, 0.0
    while passed < seconds:
        subject.step()
        done += 1
        passed = time.monotonic() - begin
    return done / passed, done / (time.process_time() - spent)


if __name__ == "__main__":
    main(sys.argv[1])
