"""A measured map of three angles predicts the curvature at one; tests/long/ has the whole."""

import map_rig

LAUNCH = map_rig.launch(-0.55, 0.0, 0.55)


class SteeringMap(map_rig.MapCase):
    """Waits for the map, then drives itself."""

    def test_map_predicts_curvature(self):
        self.check_map(3, (0.55,))
