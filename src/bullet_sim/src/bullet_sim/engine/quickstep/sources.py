"""What compiled code is made of: sources, a processor, numba."""

import functools
import hashlib
import importlib.util
import platform
from pathlib import Path

_FOLDER = Path(__file__).parent
SOURCES = sorted(_FOLDER.glob("*.py"))
CACHE = _FOLDER / "__pycache__"
_START = 1 << 14  # bytes of /proc/cpuinfo that have the first processor


@functools.lru_cache(maxsize=None)
def sources_hash() -> str:
    """Hash of all sources of what is compiled."""
    sources = hashlib.sha256()
    for path in SOURCES:
        sources.update(path.read_bytes())
    return sources.hexdigest()


def _processor() -> bytes:
    """What the first processor can do; machine code is made for it."""
    try:
        with open("/proc/cpuinfo", "rb") as stream:
            first = stream.read(_START).partition(b"\n\n")[0]
    except OSError:
        return platform.processor().encode()
    wanted = b"flags", b"Features"
    return b"\n".join(line for line in first.splitlines() if line.startswith(wanted))


def library_path() -> Path:
    """Where the library of these sources, this processor and this numba is, or would be."""
    known = hashlib.sha256(sources_hash().encode() + _processor())
    for package in ("numba", "llvmlite"):
        spec = importlib.util.find_spec(package)
        if spec is not None and spec.origin:
            version = Path(spec.origin).with_name("_version.py")
            known.update(version.read_bytes() if version.is_file() else b"")
    return CACHE / f"quickstep-{known.hexdigest()[:16]}.so"
