"""The speed limit of one joint is its own and not that of its neighbors."""

import pytest
from bullet_sim.pose import Pose
from bullet_sim.world import World

ARM = """<link name="{name}"><inertial><mass value="0.1"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001"/></inertial></link>
  <joint name="{name}_joint" type="continuous"><parent link="base"/><child link="{name}"/>
    <origin xyz="{x} 0 0"/><axis xyz="0 0 1"/><limit effort="1" velocity="{speed}"/></joint>"""
ROBOT = """<robot name="r"><link name="base"><inertial><mass value="100"/>
    <inertia ixx="10" iyy="10" izz="10"/></inertial></link>{arms}
  <gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>"""


@pytest.mark.parametrize("solver", ["ode", "bullet"])
@pytest.mark.parametrize("first, second", [(60.0, 2.0), (2.0, 60.0), (150.0, 2.0)])
def test_each_joint_reaches_its_own_limit(first, second, solver):
    world = World(gravity=(0.0, 0.0, 0.0), solver=solver)
    try:
        arms = ARM.format(name="a", x=0.5, speed=first) + ARM.format(name="b", x=-0.5, speed=second)
        robot = world.spawn_urdf("r", ROBOT.format(arms=arms), resolve=str, pose=Pose())
        for name in ("a", "b"):
            robot.manager.load(
                name,
                {"type": "velocity_controllers/JointVelocityController", "joint": f"{name}_joint"},
            )
        robot.manager.switch(["a", "b"], [], strict=True)
        for name in ("a", "b"):
            robot.manager.command(name, [1000.0])
        world.step(1000)
        speeds = dict(zip(robot.joints.names, robot.joints.arrays()[1]))
        assert speeds["a_joint"] == pytest.approx(first, rel=0.02)
        assert speeds["b_joint"] == pytest.approx(second, rel=0.02)
    finally:
        world.close()
