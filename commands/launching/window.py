"""What ./run adds to the launch arguments of the teleop window."""

import glob
import os

from commands.paths import OUT

PADS = "/dev/input/js*"


def additions(arguments, pads=PADS):
    """Gives launch arguments that the caller has not given.

    Args:
        arguments: NAME:=VALUE as they were given.
        pads: Pattern of the device files of game pads.

    Returns:
        List: recordings go to out/recordings/, the driver of a pad that is plugged in is started.
    """
    wanted = {"record_dir": os.path.join(OUT, "recordings")}
    if glob.glob(pads):
        wanted["pad"] = "true"
    given = {argument.partition(":=")[0] for argument in arguments}
    return [f"{name}:={value}" for name, value in wanted.items() if name not in given]
