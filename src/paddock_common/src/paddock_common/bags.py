"""Rosbags of others: nothing of one is executed, and what it unpacks to has a limit.

rosbag makes Python of the definitions in a bag and executes it. Here messages are read by the
installed classes alone.
"""

from __future__ import annotations

import bz2
import contextlib
import types
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import rosbag
import roslib.message

CHUNK = 1 << 29  # [B] of a chunk that is unpacked; a recording's has 768 kB, or one large message
PIECE = 4096  # [B] that are unpacked at once


class BagError(ValueError):
    """A bag cannot be read; the text names it."""


class Bag:
    """A bag, open within a with statement.

    Attributes:
        topics: the type of each.
        others: topics with messages that were left out: their definition is another one.

    Raises:
        BagError: the file is no bag, or is damaged.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self.others: set[str] = set()
        with self._reading():
            self._bag = rosbag.Bag(path)
        with self._reading():
            found = self._bag.get_type_and_topic_info().topics
            self.topics = {name: info.msg_type for name, info in found.items()}

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        self._bag.close()

    def messages(self, wanted: Mapping[str, str]) -> Iterator[tuple[str, Any, Any]]:
        """Read messages in the order of their times.

        Args:
            wanted: topics, and the type of each.

        Yields:
            Topic, message, time at which it was recorded.

        Raises:
            BagError: the file is damaged.
        """

        def is_known(topic: str, kind: str, md5sum: str, *_: object) -> bool:
            known = roslib.message.get_message_class(kind) if kind == wanted[topic] else None
            if known is None or known._md5sum != md5sum:
                self.others.add(topic)
                return False
            rosbag.bag._message_types[md5sum] = known
            return True

        with self._reading():
            rows = self._bag.read_messages(topics=[*wanted], connection_filter=is_known)
        while True:
            with self._reading():
                row = next(rows, None)
            if row is None:
                return
            yield row.topic, row.message, row.timestamp

    @contextlib.contextmanager
    def _reading(self) -> Iterator[None]:
        try:
            yield
        except rosbag.ROSBagUnindexedException as error:
            raise BagError(
                f"{self._path} was not recorded to its end: rosbag reindex {self._path}"
            ) from error
        except Exception as error:  # whatever the bytes lead rosbag to
            text = str(error) or type(error).__name__
            raise BagError(f"{self._path} is no bag that can be read: {text}") from error


def _limited(make: Callable[[], Any]) -> Callable[[bytes], bytes]:
    """A function that unpacks at most CHUNK bytes."""

    def unpack(data: bytes) -> bytes:
        unpacker, parts, size = make(), [], 0
        for at in range(0, len(data), PIECE):
            parts.append(unpacker.decompress(data[at : at + PIECE]))
            size += len(parts[-1])
            if size > CHUNK:
                raise BagError(f"a chunk has more than {CHUNK / 1e6:.0f} MB, unpacked")
            if getattr(unpacker, "eof", False):
                break
        return b"".join(parts)

    return unpack


rosbag.bag.bz2 = types.SimpleNamespace(
    decompress=_limited(bz2.BZ2Decompressor), BZ2Compressor=bz2.BZ2Compressor
)
if rosbag.bag.found_lz4:
    _lz4 = rosbag.bag.roslz4
    rosbag.bag.roslz4 = types.SimpleNamespace(
        decompress=_limited(_lz4.LZ4Decompressor), LZ4Compressor=_lz4.LZ4Compressor
    )
