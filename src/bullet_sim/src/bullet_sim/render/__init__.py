"""Camera pictures of the world, rendered from snapshots in a separate process.

The parent uses `client.RenderClient`; `order_queue` and `orders` hold what it was asked for,
`process` starts the `worker`, `mirror` is the copy of the world in it, `request` the messages
between the two, `sky` the background.
"""
