# Sourced by bash or zsh, from anywhere: the environment of ./run exec in this shell.
#
#     source PADDOCK/setup.bash
#
# A workspace that is built in this shell by catkin_make is chained to Paddock; from then on its own
# devel/setup.bash is sourced after this one.
# shellcheck shell=bash disable=SC1090,SC1091

_paddock=$(readlink -f -- "${BASH_SOURCE[0]:-$0}")
_paddock=${_paddock%/*}
if { [ -d "$_paddock/.venv" ] || "$_paddock/run" setup; } &&
  _paddock_changes=$("$_paddock/run" setup --environment); then
  eval "$_paddock_changes"
  # roscd, rosed and the like: Debian's, or those of the ROS that was sourced for the set-up. Not
  # every ROS sets ROS_ROOT, nor has them.
  if [ -n "${ZSH_VERSION:-}" ]; then _paddock=/usr/share/zsh/vendor-completions/roszsh
  else _paddock=/usr/share/bash-completion/completions/rosbash
  fi
  for _paddock_ros in "${ROS_ROOT:-/nowhere}/.." "${ROS_ETC_DIR:-/nowhere}/../../share"; do
    if [ -r "$_paddock_ros/rosbash/${_paddock##*/}" ]; then
      _paddock=$_paddock_ros/rosbash/${_paddock##*/}
      break
    fi
  done
  if [ -r "$_paddock" ]; then . "$_paddock"; fi
  unset _paddock_ros
  unset _paddock _paddock_changes
else
  unset _paddock _paddock_changes
  false
fi
