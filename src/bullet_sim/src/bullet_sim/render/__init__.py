"""Camera pictures of the world, rendered from snapshots in a separate process.

The parent uses `client.RenderClient`; `process` starts the `worker`, `mirror` is the copy of the
world in it, `order_queue` and `orders` its input, `request` the messages between both, `sky` the
background.
"""
