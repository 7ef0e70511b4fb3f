"""The measured map predicts curvatures at angles that it has not seen, to 3 %."""

import map_rig

LAUNCH = map_rig.launch(-0.7854, -0.55, -0.25, 0.0, 0.25, 0.55, 0.7854)


class SteeringMap(map_rig.MapCase):
    """Waits for the map, then drives itself."""

    def test_map_predicts_curvature(self):
        self.check_map(7, (-0.4, 0.7))
