"""paddock_gym as pip installs it: numba compiles its solver at its first start, and only then."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "unit"))
from test_gym_package import prefix, source, use  # noqa: E402, F401

pytestmark = pytest.mark.timeout(1800)  # numba compiles beside other tests


def test_what_numba_has_compiled_is_kept(prefix, tmp_path):  # noqa: F811
    packages = next(prefix.rglob("paddock_gym/__init__.py")).parents[1]
    kept = packages / "bullet_sim" / "engine" / "quickstep" / "__pycache__"
    assert not list(kept.glob("quickstep-*.so")) and not list(kept.glob("*.nbc"))
    first = use(packages, tmp_path)
    assert all(line.startswith(str(packages)) for line in first[:3]) and first[3:] == ["True"]
    compiled = {path: path.stat().st_mtime_ns for path in kept.glob("*.nb[ic]")}
    assert any(path.name.startswith("solver.advance-") for path in compiled)
    assert use(packages, tmp_path) == first
    assert {path: path.stat().st_mtime_ns for path in kept.glob("*.nb[ic]")} == compiled
