#!/usr/bin/env python3
"""Drive any robot with the keys of a terminal."""

from twist_keyboard.node import main

if __name__ == "__main__":
    main()
