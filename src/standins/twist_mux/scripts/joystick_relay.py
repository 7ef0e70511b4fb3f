#!/usr/bin/env python3
"""Scale a joystick's velocity commands and say whether they count."""

import sys

from velocity_mux.relay import main

if __name__ == "__main__":
    sys.exit(main())
