"""For the tests of ./run exec's environment: what it promises, by hand and by ./run."""

import subprocess

from run_rig import NOISE, PATIENCE, run

from commands.bootstrap import ros

# What ./run exec promises, by hand.
BY_HAND = r"""
set -e
unset PYTHONHOME CONDA_PREFIX PYENV_VERSION
export VIRTUAL_ENV=$root/.venv PYTHONNOUSERSITE=1 PYTHONUNBUFFERED=1
export OPENBLAS_NUM_THREADS=${OPENBLAS_NUM_THREADS:-1}
export LANG=${LANG:-C.UTF-8} HOME=${HOME:-$root/.cache/home}
master=${ROS_MASTER_URI:-}
PATH="/usr/bin:$PATH"
. "$root/devel/setup.bash" >/dev/null
export PATH="$root/.venv/bin:$PATH" PADDOCK_ROOT=$root
if [ ! -e "$share/xacro/package.xml" ]; then PATH="$root/src/standins/xacro:$PATH"; fi
export ROS_LOG_DIR=${ROS_LOG_DIR:-$root/.cache/ros}
PYTHONPATH=${PYTHONPATH#:} PYTHONPATH=${PYTHONPATH%:}
case :$PYTHONPATH: in
  *:$root/config/python:*) ;;
  *) export PYTHONPATH=$PYTHONPATH:$root/config/python ;;
esac
case :${GAZEBO_MODEL_PATH:-}: in
  *:$root/.cache/gazebo_models:*) ;;
  *) export GAZEBO_MODEL_PATH=${GAZEBO_MODEL_PATH:+$GAZEBO_MODEL_PATH:}$root/.cache/gazebo_models ;;
esac
if [ -z "$DISPLAY$WAYLAND_DISPLAY" ]; then
  export QT_QPA_PLATFORM="${QT_QPA_PLATFORM:-xcb;offscreen}"
fi
if ! ls /dev/snd/pcm*p >/dev/null 2>&1; then export SDL_AUDIODRIVER=${SDL_AUDIODRIVER:-dummy}; fi
if [ -z "$ROS_IP$ROS_HOSTNAME" ]; then export ROS_IP=127.0.0.1; fi
if [ -n "$master" ]; then export ROS_MASTER_URI=$master; fi
unset root share
exec /usr/bin/env -0
"""
PLAIN = {"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": "/tmp"}


def variables(done):
    """The variables that env -0 printed."""
    assert done.returncode == 0, done.stderr
    entries = [entry.split("=", 1) for entry in done.stdout.split("\0")[:-1]]
    return {name: value for name, value in entries if name not in NOISE}


def by_hand(root, environ):
    script = ["/bin/bash", "-c", BY_HAND]
    environ = {**environ, "root": str(root), "share": ros.share()}
    return variables(subprocess.run(script, env=environ, timeout=PATIENCE, capture_output=True,
                                    text=True, check=False))  # fmt: skip


def by_run(root, environ):
    return variables(run("exec", "/usr/bin/env", "-0", root=root, env=environ))
