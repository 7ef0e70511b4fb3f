"""A Debian with nothing installed, for ./run bare: what it takes over, its life, and its end.

Every program that works in it or for it runs below `inside`, in namespaces of its own: when ./run
ends, even by SIGKILL, the kernel ends the processes and drops the mounts with it.
"""
