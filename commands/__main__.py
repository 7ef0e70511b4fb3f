"""What ./run starts as /usr/bin/python3 -I -S: puts the clone on the path and goes to cli."""

import os
import sys

if sys.version_info < (3, 8):  # noqa: UP036 - this file is read by older ones, too
    sys.exit(
        "run: /usr/bin/python3 is Python {}.{}, and Paddock needs 3.8 to 3.13: a newer system, or "
        "a container with its desk in the browser (docs/container.md), will do".format(
            *sys.version_info
        )
    )
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))

from commands.cli import main  # noqa: E402

sys.exit(main(sys.argv[1:]))
