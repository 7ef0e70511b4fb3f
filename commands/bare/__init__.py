"""A Debian with nothing installed, for ./run bare: mmdebstrap makes it, bubblewrap runs it."""
