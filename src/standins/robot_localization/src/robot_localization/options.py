"""Parameters of the filters."""

from dataclasses import dataclass, fields

import numpy as np
from paddock_common.settings import converted

from robot_localization.ekf import PROCESS_NOISE, SIZE

TRUE, FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


def truth(name, value):
    """Boolean of a parameter: true, 1, "true" and so on.

    Raises:
        ValueError: It is neither true nor false; names the parameter and its value.
    """
    if isinstance(value, (bool, int, float)):
        return bool(value)
    if isinstance(value, str) and value.strip().lower() in TRUE + FALSE:
        return value.strip().lower() in TRUE
    raise ValueError(f"{name} is {value!r}, must be true or false")


def frame(name, value):
    """Name of a frame, without the leading slash of tf 1.

    Raises:
        ValueError: It is not a name.
    """
    if not isinstance(value, str) or not value.strip("/ "):
        raise ValueError(f"{name} is {value!r}, must be the name of a frame")
    return value.strip().lstrip("/")


# Known upstream, without effect here.
IGNORED = (
    "use_control",
    "stamped_control",
    "control_timeout",
    "control_config",
    "acceleration_limits",
    "acceleration_gains",
    "deceleration_limits",
    "deceleration_gains",
    "debug",
    "debug_out_file",
)
UNSCENTED = ("alpha", "kappa", "beta")  # of the unscented filter


@dataclass(frozen=True)
class Options:
    """What the node does; defaults are upstream's.

    Attributes:
        frequency: Estimates per second [Hz].
        sensor_timeout: Time without measurements after which to predict [s]; None: one period.
        two_d_mode: Whether the robot stays in the plane.
        map_frame, odom_frame, base_link_frame: Names of REP 105's frames.
        base_link_frame_output: The robot's frame in what is published; None: base_link_frame.
        world_frame: The frame of the estimate: odom_frame (the default), or map_frame.
        transform_time_offset: Added to the stamps of published frames [s].
        transform_timeout: Maximum wait for a frame [s].
        publish_tf: Whether frames are published.
        invert_tf: Whether the world is published as a child of the robot.
        publish_acceleration: Whether accel/filtered is published.
        permit_corrected_publication: Whether a time that was published may be again.
        print_diagnostics: Whether /diagnostics is published.
        reset_on_time_jump: Whether a clock that was set back restarts the filter.
        predict_to_current_time: Whether each estimate is of the present.
        smooth_lagged_data: Whether late measurements are fused at their stamps.
        history_length: How late they may be [s].
        dynamic_process_noise_covariance: Whether process noise grows with the speed.
        disabled_at_startup: Whether to wait for the service `enable`.
        gravitational_acceleration: [m/s^2].
    """

    frequency: float = 30.0
    sensor_timeout: float = None
    two_d_mode: bool = False
    map_frame: str = "map"
    odom_frame: str = "odom"
    base_link_frame: str = "base_link"
    base_link_frame_output: str = None
    world_frame: str = None
    transform_time_offset: float = 0.0
    transform_timeout: float = 0.0
    publish_tf: bool = True
    invert_tf: bool = False
    publish_acceleration: bool = False
    permit_corrected_publication: bool = False
    print_diagnostics: bool = True
    reset_on_time_jump: bool = False
    predict_to_current_time: bool = False
    smooth_lagged_data: bool = False
    history_length: float = 0.0
    dynamic_process_noise_covariance: bool = False
    disabled_at_startup: bool = False
    gravitational_acceleration: float = 9.80665


READERS = {float: converted, bool: truth, str: frame}


def read(parameters, prefix=""):
    """Reads the options; a wrong one stays as it is by default.

    Args:
        prefix: tf_prefix: put before the frames' names.

    Returns:
        (Options, one message for each that is not used).

    Raises:
        ValueError: The frames are not all different, or the frequency is not positive.
    """
    values, notes = {}, []
    for item in fields(Options):
        if item.name not in parameters:
            continue
        try:
            values[item.name] = READERS[item.type](item.name, parameters[item.name])
        except ValueError as error:
            notes.append(f"{error}; the default is used")
    options = Options(**values)
    if not options.frequency > 0.0:
        raise ValueError(f"frequency is {options.frequency:g} Hz, must be above 0")
    ignored = [name for name in IGNORED if parameters.get(name)]
    if ignored:
        notes.append(f"ignored here: {', '.join(ignored)}")
    if options.history_length and not options.smooth_lagged_data:
        notes.append("history_length has no effect without smooth_lagged_data")
    return _complete(options, prefix), notes


def _complete(options, prefix):
    values = {item.name: getattr(options, item.name) for item in fields(Options)}
    if values["base_link_frame_output"] is None:
        values["base_link_frame_output"] = options.base_link_frame
    if values["world_frame"] is None:
        values["world_frame"] = options.odom_frame
    if values["sensor_timeout"] is None:
        values["sensor_timeout"] = 1.0 / options.frequency
    values["history_length"] = abs(options.history_length)
    prefix = prefix.strip("/")
    for item in fields(Options):
        if prefix and item.type is str:
            values[item.name] = f"{prefix}/{values[item.name]}"
    options = Options(**values)
    world = (options.map_frame, options.odom_frame)
    for robot in (options.base_link_frame, options.base_link_frame_output):
        if len({robot, *world}) < 3:
            raise ValueError(
                f"map_frame '{world[0]}', odom_frame '{world[1]}' and base_link_frame '{robot}' "
                "must all be different"
            )
    if options.world_frame not in world:
        raise ValueError(
            f"world_frame is '{options.world_frame}', must be that of odom_frame '{world[1]}' or "
            f"map_frame '{world[0]}'"
        )
    return options


def read_arrays(parameters):
    """Reads first state, first covariance and process noise; a wrong one is not used.

    Returns:
        (dict of arguments of Ekf, one message for each that is not used).
    """
    arguments, notes = {"process_noise": PROCESS_NOISE}, []
    for name, argument, shape in (
        ("initial_state", "state", (SIZE,)),
        ("initial_estimate_covariance", "covariance", (SIZE, SIZE)),
        ("process_noise_covariance", "process_noise", (SIZE, SIZE)),
    ):
        if name not in parameters:
            continue
        try:
            arguments[argument] = _array(name, parameters[name], shape)
        except ValueError as error:
            notes.append(f"{error}; the default is used")
    return arguments, notes


def read_unscented(parameters):
    """Reads alpha, kappa and beta of the unscented filter; a wrong one is not used.

    Returns:
        (dict of arguments of Ukf, one message for each that is not used).
    """
    arguments, notes = {}, []
    for name in UNSCENTED:
        try:
            if name in parameters:
                arguments[name] = converted(name, parameters[name])
        except ValueError as error:
            notes.append(f"{error}; the default is used")
    return arguments, notes


def _array(name, values, shape):
    count = int(np.prod(shape))
    if not isinstance(values, list) or len(values) not in {count, SIZE}:
        length = f"has {len(values)} values" if isinstance(values, list) else f"is {values!r}"
        raise ValueError(f"{name} {length}, must have {count}")
    array = np.array([converted(name, value) for value in values])
    if len(shape) == 2 and len(values) == SIZE:
        return np.diag(array)
    return array.reshape(shape)
