"""Parameters as upstream's YAML files write them, and what is said about wrong ones."""

import os

import numpy as np
import pytest
import yaml
from robot_localization.ekf import PROCESS_NOISE
from robot_localization.options import read, read_arrays
from robot_localization.sensors import configuration_warnings
from robot_localization.sensors import read as read_sensors

NO, YES = [False] * 15, [True] * 15


def config(*places):
    return [place in places for place in range(15)]


def test_sensors_of_all_kinds():
    sensors, notes = read_sensors(
        {
            "odom0": "wheel/odom",
            "odom0_config": YES,
            "odom0_differential": True,
            "odom0_queue_size": 5,
            "odom0_pose_rejection_threshold": 5,
            "odom0_twist_rejection_threshold": 1.5,
            "odom0_nodelay": "true",
            "odom1": "visual/odom",
            "odom1_config": config(0, 6),
            "pose0": "amcl_pose",
            "pose0_config": [1] * 15,
            "pose0_rejection_threshold": 2,
            "twist0": "doppler",
            "twist0_config": YES,
            "twist0_rejection_threshold": 0.3,
            "imu0": "imu/data",
            "imu0_config": config(5, 11, 12),
            "imu0_relative": True,
            "imu0_remove_gravitational_acceleration": True,
            "imu0_linear_acceleration_rejection_threshold": 0.8,
        }
    )
    assert notes == []
    assert [(s.name, s.input_type, s.topic) for s in sensors] == [
        ("odom0", "odom", "wheel/odom"),
        ("odom1", "odom", "visual/odom"),
        ("pose0", "pose", "amcl_pose"),
        ("twist0", "twist", "doppler"),
        ("imu0", "imu", "imu/data"),
    ]
    odom0, odom1, pose0, twist0, imu0 = sensors
    never = float("inf")
    assert odom0.used == tuple([True] * 12 + [False] * 3)
    assert odom0.differential and odom0.nodelay and odom0.queue_size == 5
    assert odom0.thresholds == (5.0, 1.5, never)
    assert odom1.used == tuple(config(0, 6)) and odom1.thresholds == (never,) * 3
    assert pose0.used == tuple([True] * 6 + [False] * 9) and pose0.thresholds[0] == 2.0
    assert twist0.used == tuple([False] * 6 + [True] * 6 + [False] * 3)
    assert twist0.thresholds[1] == 0.3
    assert imu0.relative and imu0.remove_gravity and imu0.thresholds[2] == 0.8


@pytest.mark.parametrize(
    "parameters, text",
    [
        ({"odom0": "odom"}, "odom0_config is None, must be a list of 15"),
        ({"odom0": "", "odom0_config": YES}, "odom0 is '', must be a topic"),
        ({"odom0": "o", "odom0_config": NO}, "odom0_config uses nothing"),
        ({"odom0": "o", "odom0_config": ["maybe"] * 15}, "odom0_config is 'maybe'"),
        (
            {"odom0": "o", "odom0_config": YES, "odom0_pose_rejection_threshold": "far"},
            "odom0_pose_rejection_threshold is 'far'",
        ),
    ],
)
def test_a_wrong_sensor_costs_itself_alone(parameters, text):
    finite = {"imu0": "imu", "imu0_config": config(5)}
    sensors, notes = read_sensors({**parameters, **finite})
    assert [sensor.name for sensor in sensors] == ["imu0"]
    assert len(notes) == 1 and text in notes[0] and "odom0 is skipped" in notes[0]


@pytest.mark.parametrize(
    "parameters, text",
    [
        ({"odom0": "o", "odom0_config": [True] * 13}, "odom0_config has 13 values, must have 15"),
        (
            {
                "odom0": "o",
                "odom0_config": YES,
                "odom0_differential": True,
                "odom0_relative": True,
            },
            "both true",
        ),
        ({"imu0": "i", "imu0_config": config(0, 5)}, "an IMU does not measure x"),
        ({"odom0": "o", "odom0_config": YES, "odom2": "p"}, "odom2: not read"),
    ],
)
def test_what_is_odd_is_noted(parameters, text):
    sensors, notes = read_sensors(parameters)
    assert len(sensors) == 1 and len(notes) == 1 and text in notes[0]
    assert not (sensors[0].differential and sensors[0].relative)


def test_doubts_about_the_choice_of_sensors():
    wheel, other, imu = (
        {"odom0": "a", "odom0_config": config(0, 1, 6, 7, 11)},
        {"odom1": "b", "odom1_config": config(0)},
        {"imu0": "c", "imu0_config": config(5), "imu0_differential": True},
    )
    assert configuration_warnings(read_sensors(wheel)[0], True) == []
    assert [d[:2] for d in configuration_warnings(read_sensors({**wheel, **other})[0], True)] == [
        (False, "x")
    ]
    assert [d[:2] for d in configuration_warnings(read_sensors(imu)[0], True)] == [
        (True, "x"),
        (True, "y"),
    ]
    names = [d[1] for d in configuration_warnings(read_sensors(wheel)[0], False)]
    assert names == ["z", "roll", "pitch"]


def test_options_by_default():
    options, notes = read({})
    assert notes == []
    assert (options.frequency, options.sensor_timeout) == (30.0, 1.0 / 30.0)
    assert (options.map_frame, options.odom_frame) == ("map", "odom")
    assert options.world_frame == "odom" and options.base_link_frame_output == "base_link"
    assert options.publish_tf and options.print_diagnostics and not options.two_d_mode


def test_options_given():
    options, notes = read(
        {
            "frequency": 50,
            "two_d_mode": "true",
            "odom_frame": "/robot_odom",
            "base_link_frame": "base_footprint",
            "world_frame": "map",
            "history_length": -2.0,
            "smooth_lagged_data": True,
            "publish_tf": 0,
        }
    )
    assert notes == []
    assert options.frequency == 50.0 and options.sensor_timeout == 0.02
    assert options.two_d_mode and not options.publish_tf
    assert options.odom_frame == "robot_odom" and options.world_frame == "map"
    assert options.base_link_frame_output == "base_footprint" and options.history_length == 2.0


def test_a_prefix_goes_before_every_frame():
    options, _ = read({"world_frame": "map"}, "/car1")
    assert options.world_frame == options.map_frame == "car1/map"
    assert options.base_link_frame_output == "car1/base_link"


def test_what_is_ignored_is_said_in_one_sentence():
    _, notes = read({"use_control": True, "control_config": [True] * 6, "debug": False})
    assert notes == ["ignored here: use_control, control_config"]


def test_a_wrong_option_keeps_its_default():
    options, notes = read({"frequency": "often", "odom_frame": "", "publish_tf": "perhaps"})
    assert (options.frequency, options.odom_frame, options.publish_tf) == (30.0, "odom", True)
    assert len(notes) == 3 and "frequency is 'often'" in notes[0]


@pytest.mark.parametrize(
    "parameters, text",
    [
        ({"frequency": 0}, "frequency is 0 Hz"),
        ({"map_frame": "odom"}, "must all be different"),
        ({"base_link_frame_output": "odom"}, "must all be different"),
        ({"world_frame": "earth"}, "world_frame is 'earth'"),
    ],
)
def test_what_cannot_be_run(parameters, text):
    with pytest.raises(ValueError, match=text):
        read(parameters)


def test_arrays():
    given, notes = read_arrays(
        {
            "initial_state": list(range(15)),
            "initial_estimate_covariance": (2 * np.eye(15)).ravel().tolist(),
            "process_noise_covariance": [1e-3] * 15,
        }
    )
    assert notes == []
    assert given["state"].tolist() == list(range(15))
    assert (given["covariance"] == 2 * np.eye(15)).all()
    assert (given["process_noise"] == 1e-3 * np.eye(15)).all()


def test_wrong_arrays_are_not_used():
    given, notes = read_arrays({"initial_state": [1.0], "process_noise_covariance": ["much"] * 225})
    assert "state" not in given and given["process_noise"] is PROCESS_NOISE
    assert "initial_state has 1 values, must have 15" in notes[0]
    assert "process_noise_covariance is 'much'" in notes[1]


PARAMS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "params")


@pytest.mark.parametrize("name", ["ekf_template", "ukf_template", "dual_ekf_navsat_example"])
def test_templates_are_read_without_a_note(name):
    with open(os.path.join(PARAMS, f"{name}.yaml"), encoding="utf-8") as stream:
        content = yaml.safe_load(stream)
    filters = [value for key, value in content.items() if key.startswith("ekf_se")] or [content]
    assert len(filters) == (2 if name.startswith("dual") else 1)
    for parameters in filters:
        sensors, notes = read_sensors(parameters)
        assert len(sensors) >= 2
        assert notes + read(parameters)[1] + read_arrays(parameters)[1] == []


def test_the_template_holds_the_defaults():
    with open(os.path.join(PARAMS, "ekf_template.yaml"), encoding="utf-8") as stream:
        content = yaml.safe_load(stream)
    given, default = read({**content, "sensor_timeout": 1 / 30.0})[0], read({})[0]
    assert given == default
    arrays = read_arrays(content)[0]
    assert (arrays["process_noise"] == PROCESS_NOISE).all()
    assert (arrays["covariance"] == 1e-9 * np.eye(15)).all()


def test_parts_of_sensors_as_diagnostics_name_them():
    sensors, _ = read_sensors(
        {
            "odom0": "odom",
            "odom0_config": config(0, 6),
            "pose0": "pose",
            "pose0_config": config(0),
            "imu0": "imu",
            "imu0_config": config(5, 11, 12),
        }
    )
    assert {sensor.name: sensor.parts() for sensor in sensors} == {
        "odom0": ["odom0_pose", "odom0_twist"],
        "pose0": ["pose0"],
        "imu0": ["imu0_pose", "imu0_twist", "imu0_acceleration"],
    }
