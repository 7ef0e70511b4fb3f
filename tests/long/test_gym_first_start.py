"""paddock_gym as pip installs it compiles its solver at its first start, once."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "unit"))
from test_gym_package import library_path, prefix, use  # noqa: E402, F401


def test_the_first_start_makes_the_library_that_the_next_one_loads(prefix, tmp_path):  # noqa: F811
    packages = next(prefix.rglob("paddock_gym/__init__.py")).parents[1]
    kept = packages / "bullet_sim" / "engine" / "quickstep" / "__pycache__"
    assert not list(kept.glob("quickstep-*"))
    *files, has_numba = use(packages, tmp_path)
    assert len(files) == 3 and all(line.startswith(str(packages)) for line in files)
    assert has_numba == "True"
    assert [path.name for path in kept.glob("quickstep-*")] == [library_path().name]
    assert use(packages, tmp_path) == [*files, "False"]
