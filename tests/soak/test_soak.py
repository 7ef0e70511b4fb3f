"""Two minutes of ./run soak; its page is left in test-results/soak."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.timeout(900)
def test_two_minutes():
    options = ["--minutes", "2", "--seed", "1", "--folder", str(ROOT / "test-results" / "soak")]
    done = subprocess.run(
        [sys.executable, str(ROOT / "bench" / "soak.py"), *options],
        check=False,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    print(done.stdout)
    assert done.returncode == 0
