#!/usr/bin/env python3
"""Scale a joystick's velocity commands and publish their priority."""

from velocity_mux.relay import main

if __name__ == "__main__":
    main()
