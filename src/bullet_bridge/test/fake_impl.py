"""A publisher, and what stands behind it: takes packed messages as rospy's topic does."""

import io


class Impl:
    """Hands messages, read back from their bytes, to the fake publisher that owns it.

    Args:
        owner: has kind and publish(message).
    """

    closed = is_latch = False

    def __init__(self, owner):
        self._owner, self.seq, self.message_data_sent, self.connections = owner, 0, 0, [self]

    def acquire(self):
        """Nobody else publishes."""

    def release(self):
        """Nobody else publishes."""

    def write_data(self, data):
        """Read back, hand over."""
        assert len(data) == 4 + int.from_bytes(data[:4], "little")
        self._owner.publish(self._owner.kind().deserialize(data[4:]))


class Topic:
    """Stands in for a publisher."""

    def __init__(self, name, kind):
        self.name, self.kind, self.messages, self.subscribers = name, kind, [], 1
        self.closed, self.impl = False, Impl(self)

    def publish(self, message):
        """Keep it, and see that it can be sent."""
        message.serialize(io.BytesIO())
        self.messages.append(message)

    def get_num_connections(self):
        """One subscriber unless a test sets another number."""
        return self.subscribers

    def unregister(self):
        """Close; nothing stands behind it any more, as with rospy's."""
        self.closed, self.impl = True, None
