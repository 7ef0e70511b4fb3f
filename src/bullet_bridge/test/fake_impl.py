"""What stands behind a publisher: takes packed messages as rospy's topic does."""


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
