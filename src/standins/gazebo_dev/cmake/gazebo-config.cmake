# The file by which find_package(gazebo) finds Gazebo Classic where the system has none: the libraries
# of ./run add gazebo (see commands/gazebo_libraries.py). Without them it finds neither headers nor
# libraries, and programs that only ask for Gazebo can be built.
set(GAZEBO_FOUND TRUE)
set(GAZEBO_VERSION 11.15.1)
set(GAZEBO_MAJOR_VERSION 11)
set(GAZEBO_MINOR_VERSION 15)
set(GAZEBO_PATCH_VERSION 1)
foreach(name
    INCLUDE_DIRS LIBRARIES LIBRARY_DIRS LDFLAGS CFLAGS CXX_FLAGS
    PLUGIN_PATH MODEL_PATH MEDIA_PATH PROTO_PATH PROTO_INCLUDE_DIRS PROTO_LIBRARIES)
  set(GAZEBO_${name} "")
  set(gazebo_${name} "")
endforeach()
# This file is in src/standins/gazebo_dev/cmake or, for chained workspaces, in devel/share/gazebo/cmake.
get_filename_component(paddock_gazebo "${CMAKE_CURRENT_LIST_DIR}/../../../../.cache/gazebo" ABSOLUTE)
if(NOT EXISTS "${paddock_gazebo}/packages.txt")
  return()
endif()

include("${CMAKE_CURRENT_LIST_DIR}/gazebo-protobuf.cmake")
set(GAZEBO_VERSION 11.1.0)
set(GAZEBO_MINOR_VERSION 1)
set(GAZEBO_PATCH_VERSION 0)
file(GLOB paddock_gazebo_libraries LIST_DIRECTORIES TRUE "${paddock_gazebo}/usr/lib/*-linux-gnu")
file(GLOB GAZEBO_LIBRARY_DIRS LIST_DIRECTORIES TRUE "${paddock_gazebo}/lib/*-linux-gnu")
set(GAZEBO_LIBRARY_DIRS
  "${paddock_gazebo_libraries}" "${paddock_gazebo}/usr/lib" ${GAZEBO_LIBRARY_DIRS})
file(GLOB GAZEBO_INCLUDE_DIRS LIST_DIRECTORIES TRUE
  "${paddock_gazebo}/usr/include/gazebo-11" "${paddock_gazebo}/usr/include/sdformat-*"
  "${paddock_gazebo}/usr/include/ignition/*" "${paddock_gazebo}/usr/include/OGRE"
  "${paddock_gazebo}/usr/include/OGRE/Terrain" "${paddock_gazebo}/usr/include/OGRE/Paging"
  "${paddock_gazebo}/usr/include/*-linux-gnu")
list(APPEND GAZEBO_INCLUDE_DIRS "${paddock_gazebo}/usr/include")
# ROS has headers and libraries of all its packages in one folder each, and packages forget whose they
# include and link.
get_filename_component(paddock_root "${paddock_gazebo}/../.." ABSOLUTE)
list(APPEND GAZEBO_INCLUDE_DIRS "${paddock_root}/src/standins/gazebo_plugins/include")
set(GAZEBO_PLUGIN_PATH "${paddock_gazebo_libraries}/gazebo-11/plugins")
set(GAZEBO_PROTO_PATH "${paddock_gazebo}/usr/include/gazebo-11/gazebo/msgs/proto")
set(GAZEBO_PROTO_INCLUDE_DIRS "${paddock_gazebo}/usr/include/gazebo-11/gazebo/msgs")
set(GAZEBO_PROTO_LIBRARIES "${paddock_gazebo_libraries}/libgazebo_msgs.so")
list(APPEND GAZEBO_LIBRARY_DIRS "${GAZEBO_PLUGIN_PATH}")
set(GAZEBO_CXX_FLAGS "-std=c++17")
# A target, as its options come behind those of a package: these headers need C++ 17, whatever it asks for.
if(NOT TARGET paddock_gazebo_libraries)
  add_library(paddock_gazebo_libraries INTERFACE IMPORTED GLOBAL)
  set(libraries "")
  foreach(name
      gazebo gazebo_client gazebo_sensors gazebo_rendering gazebo_physics gazebo_transport gazebo_msgs
      gazebo_util gazebo_common sdformat9 ignition-math6 ignition-msgs5 ignition-transport8
      ignition-common3 ignition-fuel_tools4 OgreMain OgreTerrain OgrePaging protobuf)
    list(APPEND libraries "${paddock_gazebo_libraries}/lib${name}.so")
  endforeach()
  find_package(Boost QUIET COMPONENTS
    thread system filesystem program_options regex iostreams date_time)
  set_target_properties(paddock_gazebo_libraries PROPERTIES
    INTERFACE_LINK_LIBRARIES "${libraries};${Boost_LIBRARIES}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${GAZEBO_INCLUDE_DIRS}"
    INTERFACE_LINK_DIRECTORIES "${paddock_root}/devel/lib"
    INTERFACE_COMPILE_FEATURES cxx_std_17
    INTERFACE_COMPILE_OPTIONS "$<$<COMPILE_LANGUAGE:CXX>:-std=gnu++17>;$<$<COMPILE_LANGUAGE:CXX>:-DBOOST_BIND_GLOBAL_PLACEHOLDERS>;$<$<COMPILE_LANGUAGE:CXX>:--include=boost/bind.hpp>")
  set(rpath_link "")
  foreach(folder IN LISTS GAZEBO_LIBRARY_DIRS)
    list(APPEND rpath_link "-Wl,-rpath-link,${folder}")
  endforeach()
  set_property(TARGET paddock_gazebo_libraries PROPERTY INTERFACE_LINK_OPTIONS "${rpath_link}")
endif()
set(GAZEBO_LIBRARIES paddock_gazebo_libraries)
foreach(name INCLUDE_DIRS LIBRARIES LIBRARY_DIRS CXX_FLAGS PLUGIN_PATH)
  set(gazebo_${name} "${GAZEBO_${name}}")
endforeach()
