# shellcheck shell=sh
# navigate.launch takes teb where it is built: it reaches goals that DWA, once past them, drives away from.
for _paddock_prefix in $(echo "${CMAKE_PREFIX_PATH:-}" | tr ':' ' '); do
  if [ -e "$_paddock_prefix/lib/libteb_local_planner.so" ]; then
    export PADDOCK_PLANNER="${PADDOCK_PLANNER:-teb}"
  fi
done
unset _paddock_prefix
