"""Several cars in one world drive as each alone would."""

import gymnasium
import numpy as np
import pytest
from paddock_gym.errors import GymError

import paddock_gym

ID = paddock_gym.IDS[0]


def cars(count, **options):
    return gymnasium.make_vec(
        ID, num_envs=count, vectorization_mode="vector_entry_point", **options
    )


def test_each_car_drives_as_alone():
    """To the bit, until one of them starts anew; they all begin at the same place."""
    vector, count = cars(4), 4
    alone = gymnasium.make(ID).unwrapped
    seen, _ = vector.reset(seed=[7] * count)
    rng = np.random.default_rng(1)
    actions = rng.uniform((-0.3, -1.0), (0.3, -0.3), (30, count, 2)).astype(np.float32)
    together = [(seen, np.zeros(count), np.zeros(count, bool))]
    for row in actions:
        seen, rewards, terminated, _, _ = vector.step(row)
        together.append((seen, rewards, terminated))
    for number in range(count):
        seen, _ = alone.reset(seed=7)
        assert (together[0][0][number] == seen).all()
        for row, (observations, rewards, ends) in zip(actions, together[1:]):
            seen, reward, terminated, _, _ = alone.step(row[number])
            assert (observations[number] == seen).all()
            assert rewards[number] == reward and ends[number] == terminated
            if terminated:
                break
    vector.close(), alone.close()


def test_a_car_starts_anew_after_its_end():
    vector = cars(2)
    vector.reset(seed=3)
    over = np.zeros(2, bool)
    ends = 0
    for _ in range(120):
        before = over
        seen, rewards, terminated, truncated, infos = vector.step(np.array([[1, 0], [0, -1]], "f"))
        over = terminated | truncated
        for number in np.flatnonzero(before):
            assert rewards[number] == 0.0 and not over[number]
            assert infos["progress"][number] == 0.0 and infos["end"][number] == ""
            assert abs(seen[number][3]) < 1e-6  # at rest
        ends += np.count_nonzero(over)
    assert ends >= 3
    vector.close()


def test_the_lidar_does_not_see_the_other_cars():
    vector = cars(3, observation="lidar", walls=True, randomize=())
    seen, _ = vector.reset(seed=[5, 5, 5])
    assert (seen[0] == seen[1]).all() and (seen[0] == seen[2]).all()
    assert seen[0].min() > 0.02  # nothing as near as a car inside one's own
    vector.close()


@pytest.mark.parametrize(
    "options, words",
    [
        ({"observation": "camera"}, "which would see the other cars"),
        ({"render_mode": "rgb_array"}, "several cars have no picture"),
    ],
)
def test_wrong_options(options, words):
    with pytest.raises(GymError, match=words):
        cars(2, **options)
