"""others NAME: one environment of ../others.py, in the Python in which it is installed.

Needs nothing of the bench. Says once, as JSON, what a step of it is; then for each line on stdin
(seconds) steps that long and says how many steps a second that were.
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
        scene = (self.env.envs[0] if self._many else self.env).unwrapped.scene
        self.period, self.time_step = scene.period, scene.world.time_step
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


KINDS = {
    "paddock_state_1": lambda: Paddock("state", 1),
    "paddock_state_16": lambda: Paddock("state", 16),
    "paddock_lidar_1": lambda: Paddock("lidar", 1),
    "paddock_lidar_16": lambda: Paddock("lidar", 16),
    "f1tenth_1": lambda: F1tenth(1),
    "f1tenth_16": lambda: F1tenth(16),
    "car_racing": CarRacing,
}


def main(name):
    """Serve rounds until stdin ends; what libraries print goes to stderr."""
    answers, sys.stdout = sys.stdout, sys.stderr
    subject = KINDS[name]()
    subject.step()
    rate(subject, WARM_UP)
    about = {key: getattr(subject, key) for key in ("period", "time_step", "cars")}
    print(json.dumps(about), file=answers, flush=True)
    for line in sys.stdin:
        print(json.dumps({"rate": rate(subject, float(line))}), file=answers, flush=True)


def rate(subject, seconds):
    """Steps a second over a round of at least one step.

    Args:
        subject: of KINDS.
        seconds: wall time of the round.
    """
    begin, done, passed = time.monotonic(), 0, 0.0
    while passed < seconds:
        subject.step()
        done += 1
        passed = time.monotonic() - begin
    return done / passed


if __name__ == "__main__":
    main(sys.argv[1])
