"""What stands behind a publisher: takes packed messages as rospy's topic does."""
import io


class Impl:
    """Hands messages, read back from their bytes, to the fake publisher that owns it.

    Args:
        owner: has kind and publish(message).
    """

    def __init__(self, owner):
        self._owner, self.seq = owner, 0

    def acquire(self):
        """Nobody else publishes."""

    def release(self):
        """Nobody else publishes."""

    def publish(self, message):
        """Serialise, read back, hand over."""
        self.seq += 1
        buffer = io.BytesIO()
        message.serialize(buffer)
        self._owner.publish(self._owner.kind().deserialize(buffer.getvalue()))
