"""Makes steps of a model with a plugin in C++, without ROS: MODEL.sdf STEPS [BODY_CODE].

Prints the state of its link and of its joints, each number in hexadecimal: to the bit. The code has
`world`, `model` and `Pose`, and runs before each step.
"""

import re
import sys

from bullet_bridge.gazebo_host.host import GazeboHost
from bullet_bridge.gazebo_host.libraries import users_libraries
from bullet_sim.plugins import cpp
from bullet_sim.pose import Pose
from bullet_sim.world import World


def main():
    path, steps, code = sys.argv[1], int(sys.argv[2]), "".join(sys.argv[3:])
    cpp.use(users_libraries())
    with open(path, encoding="utf-8") as file:
        text = file.read()
    world = World()
    model = world.spawn_sdf("thing", text, Pose((0.0, 0.0, 1.0)), lambda uri: uri)
    for warning in model.description.warnings:
        print("warning:", warning)
    if "<plugin" in text:
        host = GazeboHost(world)
        for spec in model.description.sensors:
            host.load(spec, model)
    run = compile(code, "code", "exec")
    for _ in range(steps):
        exec(run, {"world": world, "model": model, "Pose": Pose})
        world.step()
    pose, linear, angular = model.link_state("link")
    print_state("state", [*pose.position, *pose.orientation, *linear, *angular])
    for name, state in zip(model.body.joints, model.body.joint_states()):
        print_state(re.sub(r"\W", "_", name), state[:2])


def print_state(name, numbers):
    print(name, *(float(number).hex() for number in numbers), flush=True)


main()
