"""Camera images of the world, rendered from snapshots in a separate process.

The parent uses `client.RenderClient`; `worker_process` starts the `worker`, `request` has the
messages between the two, `renderer` what both renderers share, `pybullet_renderer` PyBullet's.
"""
