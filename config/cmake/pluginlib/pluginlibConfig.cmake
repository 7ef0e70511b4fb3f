# Debian's pluginlib, with the header of boost that Noetic's includes and packages count on.
set(pluginlib_DIR "/usr/share/pluginlib/cmake")
include("${pluginlib_DIR}/pluginlibConfig.cmake")
list(REMOVE_ITEM pluginlib_INCLUDE_DIRS "${CMAKE_CURRENT_LIST_DIR}/include")
list(INSERT pluginlib_INCLUDE_DIRS 0 "${CMAKE_CURRENT_LIST_DIR}/include")
