"""Pictures of the world, made in a process of their own from snapshots.

The parent uses `client.RenderClient`; `process` starts the `worker`, `mirror` is the copy of the
world in it, `request` what travels between the two, `sky` the background.
"""
