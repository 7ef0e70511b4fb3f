"""Settings of the drive node besides the truck's dimensions, odometry errors and pad axes."""

from dataclasses import dataclass

from paddock_common.settings import check, choice, flag, number, text

ODOM_SOURCES = ("wheels", "ground_truth")


@dataclass(frozen=True)
class Settings:
    """Parameters of the node.

    Attributes:
        command_timeout: Age of a command above which the truck stops [s].
        start_x, start_y, start_yaw: Pose that wheel odometry starts from [m], [rad].
        odom_source: "wheels" or "ground_truth".
        odom_frame, base_frame: Frames of /odom and TF.
        joy: Whether /joy drives.
    """

    command_timeout: float = number(0.5, above=0.0, unit="s")
    start_x: float = number(0.0, unit="m")
    start_y: float = number(0.0, unit="m")
    start_yaw: float = number(0.0, unit="rad")
    odom_source: str = choice("wheels", ODOM_SOURCES)
    odom_frame: str = text("odom")
    base_frame: str = text("base_footprint")
    joy: bool = flag(False)

    def __post_init__(self):
        check(self)
