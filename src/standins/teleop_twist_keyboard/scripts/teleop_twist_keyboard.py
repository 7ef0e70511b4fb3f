#!/usr/bin/env python3
"""Drive any robot with the keys of a terminal."""

import sys

from twist_keyboard.node import main

if __name__ == "__main__":
    sys.exit(main())
