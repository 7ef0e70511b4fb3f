"""What ./run starts as /usr/bin/python3 -I -S: puts the clone on the path and goes to cli."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))

from commands.cli import main  # noqa: E402

sys.exit(main(sys.argv[1:]))
