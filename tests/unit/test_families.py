"""Each file that enters classes in a registry is loaded; a sensor in one that is not is unknown."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[2] / "src"
ENTERS = re.compile(r"^@(?:CONTROLLERS\.register|sensor_plugin|model_plugin|ros_side)\(", re.M)
LOADED_BY = {  # folder -> the import that has to load its files
    "bullet_sim/plugins": "bullet_sim.plugins",
    "bullet_sim/controllers": "bullet_sim.controllers",
    "bullet_bridge/plugins": "bullet_bridge.plugins",
    "bullet_bridge/control": "bullet_bridge.robots",
}


@pytest.mark.parametrize("folder", LOADED_BY)
def test_each_family_is_loaded(folder):
    package = folder.split("/")[0]
    files = sorted((SRC / package / "src" / folder).glob("*.py"))
    wanted = [path.stem for path in files if ENTERS.search(path.read_text())]
    assert wanted
    script = f"import sys, {LOADED_BY[folder]}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    loaded = done.stdout.split()
    for name in wanted:
        module = f"{folder}/{name}".replace("/", ".")
        where = f"src/{package}/src/{folder}/__init__.py"
        assert module in loaded, f"{module} is not loaded: import it in {where}"
