"""./run check on more launch files; runs with ./run test long."""

import check_rig
from check_rig import OTHERS


class Others(check_rig.Rig):
    """What is long."""

    STYLES = OTHERS

    def test_cars_with_masks_of_their_own_stand_in_one_place(self):
        for name in ("red", "green", "blue"):
            car = self.model("ghosts", name)
            x, y, z = car["after"]["position"]
            self.assertAlmostEqual(x, 1.0, delta=0.01)
            self.assertAlmostEqual(y, 0.0, delta=0.01)
            self.assertAlmostEqual(z, 0.0, delta=0.01)
            self.assertEqual({state for _, _, state in car["controllers"]}, {"running"})

    def test_controllers_of_a_base_behind_a_relay(self):
        names = {(name, state) for name, _, state in self.model("tug", "tug")["controllers"]}
        self.assertEqual(
            names,
            {("joint_state_controller", "running"), ("mobile_base_controller", "running")},
        )

    def test_controllers_of_four_steered_wheels_run(self):
        self.check_controllers("crab", "crab", {"FourWheelSteeringController"})

    def test_controllers_of_an_arm_run(self):
        kinds = {"JointTrajectoryController", "GripperActionController"}
        self.check_controllers("arm", "crane", kinds)
