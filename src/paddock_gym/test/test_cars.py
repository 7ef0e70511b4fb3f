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
    """Bit-identical until one of them restarts; they all start at the same pose."""
    vector, count = cars(4), 4
    alone = gymnasium.make(ID).unwrapped
    observation, _ = vector.reset(seed=[7] * count)
    rng = np.random.default_rng(1)
    actions = rng.uniform((-0.3, -1.0), (0.3, -0.3), (30, count, 2)).astype(np.float32)
    together = [(observation, np.zeros(count), np.zeros(count, bool))]
    for row in actions:
        observation, rewards, terminated, _, _ = vector.step(row)
        together.append((observation, rewards, terminated))
    for number in range(count):
        observation, _ = alone.reset(seed=7)
        assert (together[0][0][number] == observation).all()
        for row, (observations, rewards, ends) in zip(actions, together[1:]):
            observation, reward, terminated, _, _ = alone.step(row[number])
            assert (observations[number] == observation).all()
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
        observation, rewards, terminated, truncated, infos = vector.step(
            np.array([[1, 0], [0, -1]], "f")
        )
        over = terminated | truncated
        for number in np.flatnonzero(before):
            assert rewards[number] == 0.0 and not over[number]
            assert infos["progress"][number] == 0.0 and infos["end"][number] == ""
            assert abs(observation[number][3]) < 1e-6  # at rest
        ends += np.count_nonzero(over)
    assert ends >= 3
    vector.close()


def test_the_lidar_does_not_see_the_other_cars():
    vector = cars(3, observation="lidar", walls=True, randomize=())
    observation, _ = vector.reset(seed=[5, 5, 5])
    assert (observation[0] == observation[1]).all() and (observation[0] == observation[2]).all()
    assert observation[0].min() > 0.02  # no range as short as to a car at the same pose
    vector.close()


@pytest.mark.parametrize(
    "options, words",
    [
        ({"observation": "camera"}, "in which the other cars would be visible"),
        ({"render_mode": "rgb_array"}, "several cars render no image"),
    ],
)
def test_wrong_options(options, words):
    with pytest.raises(GymError, match=words):
        cars(2, **options)
