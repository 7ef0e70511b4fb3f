"""rosrun bullet_bridge sending_figures measures each stage of sending in a bridge of its own."""

import subprocess

LIMIT = 240.0  # wall time [s]


def test_each_stage_gets_a_line():
    words = ["rosrun", "bullet_bridge", "sending_figures", "--pairs", "2", "--seconds", "0.04"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=LIMIT, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    lines = done.stdout.splitlines()
    assert any(line.startswith("2 pairs, ") for line in lines)
    for stage in ("packed messages", "relay (against direct sending)", "batch", "nothing"):
        assert any(line.startswith(stage) and "%" in line for line in lines), stage
