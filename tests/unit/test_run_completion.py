"""Completion of ./run in a real bash: by its function, and by TAB in an interactive shell."""

import os
import pty
import select
import signal
import time

from run_rig import PATIENCE, ROOT, program, ran, run

from commands.table import COMMANDS

# Splits lines as bash does, calls the function that `complete -p run` names, prints its answers.
ASK = r"""
source <("$ROOT/run" completion) || exit 3
function_name=$(complete -p run | sed 's/.* -F \([^ ]*\) .*/\1/')
for line in "$@"; do
  COMP_LINE=$line COMP_POINT=${#line} COMPREPLY=(nothing)
  read -ra COMP_WORDS <<<"$line"
  case $line in *' ') COMP_WORDS+=('') ;; esac
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  "$function_name" "${COMP_WORDS[0]}" "${COMP_WORDS[COMP_CWORD]}" ''
  printf '%s\n' "${COMPREPLY[*]}"
done
"""
OFFERED = {
    "./run ": sorted(COMMANDS),
    "./run l": ["lap", "lockstep:="],
    "./run tr": ["track:=", "train", "truck"],
    "./run lap --": ["--driver", "--help", "--policy", "--starts", "--track"],
    "./run lap --driver ": ["buttons", "line", "policy", "pursuit", "slider"],
    "./run lap --driver p": ["policy", "pursuit"],
    "./run add teb_l": ["teb_local_planner"],
    "./run cluster ": ["head", "join"],
    "./run lap --track ": ["default", "easy", "hard", "medium"],
    "./run lap --driver line --track m": ["medium"],
    "./run world track:=ha": ["hard"],
    "./run world gui:=": ["false", "true"],
    "./run world renderer:=g": ["gl"],
    "./run world track:=hard ren": ["renderer:="],
    "./run track:=hard ren": ["renderer:="],
    "./run truck --back l": ["lane-change", "line"],
    "./run truck --back line sp": ["speed:="],
    "./run test saved_w": ["saved_world"],
    "./run test bullet_": ["bullet_bridge", "bullet_sim", "bullet_web"],
    "./run test --li": ["--list"],
    "./run bench --only eff": ["efficiency"],
    "./run exec catkin_mak": ["catkin_make", "catkin_make_isolated"],
    "./run exec catkin_make --he": [],
    "./run nosuch ": [],
}


def completed(*lines):
    """Asks bash what it offers for some lines."""
    done = ran("bash", "-c", ASK, "bash", *lines, env={**os.environ, "ROOT": str(ROOT)}, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")
    return [line.split() for line in done.stdout.splitlines()]


def test_offers():
    assert completed(*OFFERED) == list(OFFERED.values())


def test_another_program_called_run_is_left_alone(tmp_path):
    program(tmp_path / "run", "#!/bin/sh\necho started\n")
    assert completed(f"{tmp_path}/run ") == [[]]


def test_filters_select_what_is_listed():
    done = run("test", "--list", "saved_world", "mypy")
    assert done.returncode == 0, done.stdout
    listed = {line.partition("::")[0] for line in done.stdout.splitlines() if "::" in line}
    assert listed == {"tests/ros/test_saved_world.py", "tests/lint/test_lint.py"}


def test_tab_in_an_interactive_shell():
    process, terminal = pty.fork()
    if process == 0:
        os.chdir(ROOT)
        os.execvpe("bash", ["bash", "--norc", "--noprofile", "-i"],
                   {**os.environ, "PS1": "ready> ", "TERM": "dumb"})  # fmt: skip
    try:
        read_until(terminal, "ready> ")
        os.write(terminal, b"source <(./run completion); echo sou''rced\n")
        read_until(terminal, "sourced")
        os.write(terminal, b": ; ./run world track:=ha\t")
        read_until(terminal, "track:=hard")
        os.write(terminal, b"\x15./run lap --driver pu\t--sta\t")
        read_until(terminal, "--driver pursuit --starts")
    finally:
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        os.close(terminal)


def read_until(terminal, text):
    """Reads what a terminal shows until some text is there."""
    shown, end = "", time.monotonic() + PATIENCE
    while text not in shown:
        assert time.monotonic() < end, shown
        if select.select([terminal], [], [], 1.0)[0]:
            shown += os.read(terminal, 4096).decode(errors="replace")
    return shown
