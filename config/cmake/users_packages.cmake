# Helps old C++ of packages that a user has put into src/. CMake includes this file after each
# project(); ./run writes PADDOCK_HELP, which sets for the folder of each such package what it needs:
# a list of placeholders, headers, ffmpeg, eigen, glog, standard, protobuf, pluginlib, include_NAME and
# boost_NAME of Boost, messages_NAME. Packages that need nothing are left alone. It may name another
# pluginlib for all, and has the names of packages that are configured first.

if(NOT DEFINED PADDOCK_HELP OR NOT EXISTS "${PADDOCK_HELP}")
  return()
endif()
# Without tests catkin refuses these where they are not in if(CATKIN_ENABLE_TESTING), which they may
# be left out of where tests are built, as is usual. Programs are declared, but no part of `all`.
if(NOT CATKIN_ENABLE_TESTING AND NOT PROJECT_NAME STREQUAL "Project")
  foreach(name IN ITEMS catkin_run_tests_target catkin_add_nosetests catkin_download_test_data)
    function(${name})
    endfunction()
  endforeach()
  foreach(name IN ITEMS catkin_add_gtest catkin_add_gmock
      catkin_add_executable_with_gtest catkin_add_executable_with_gmock)
    function(${name} target)
      cmake_parse_arguments(test "EXCLUDE_FROM_ALL" "TIMEOUT;WORKING_DIRECTORY" "" ${ARGN})
      add_executable(${target} EXCLUDE_FROM_ALL ${test_UNPARSED_ARGUMENTS})
    endfunction()
  endforeach()
endif()
# FindG2O.cmake of other packages wants a library of g2o's examples, which libg2o.cmake leaves out; it
# is theirs to link, but nobody calls it.
if(EXISTS "${CATKIN_DEVEL_PREFIX}/lib/libg2o_core.so" AND NOT G2O_INCREMENTAL_LIB)
  set(G2O_INCREMENTAL_LIB "" CACHE FILEPATH "of g2o's examples")
endif()
set(PADDOCK_FIRST "${CMAKE_CURRENT_LIST_DIR}")  # headers that are included first
include("${PADDOCK_HELP}")
# The order that catkin has found stays but for PADDOCK_CONFIGURED_FIRST, which asks for nothing else.
# It is put into force where catkin sets what comes after its lists, and in their scope: by a macro.
macro(paddock_order variable access)
  if("${access}" STREQUAL "MODIFIED_ACCESS")
    set(paddock_lists CATKIN_ORDERED_PACKAGES CATKIN_ORDERED_PACKAGE_PATHS
      CATKIN_ORDERED_PACKAGES_IS_META CATKIN_ORDERED_PACKAGES_BUILD_TYPE)
    set(paddock_names "${CATKIN_ORDERED_PACKAGES}")
    foreach(list IN LISTS paddock_lists)
      set(paddock_first "")
      set(paddock_last "")
      set(paddock_index 0)
      foreach(name IN LISTS paddock_names)
        list(GET ${list} ${paddock_index} value)
        list(FIND PADDOCK_CONFIGURED_FIRST "${name}" paddock_found)
        if(paddock_found EQUAL -1)
          list(APPEND paddock_last "${value}")
        else()
          list(APPEND paddock_first "${value}")
        endif()
        math(EXPR paddock_index "${paddock_index} + 1")
      endforeach()
      set(${list} ${paddock_first} ${paddock_last})
    endforeach()
  endif()
endmacro()
if(PROJECT_NAME STREQUAL "Project")
  variable_watch(CATKIN_METAPACKAGE_CMAKE_TEMPLATE paddock_order)
endif()
if(NOT DEFINED "paddock_help_${CMAKE_CURRENT_SOURCE_DIR}")
  return()
endif()
list(FIND "paddock_help_${CMAKE_CURRENT_SOURCE_DIR}" protobuf paddock_protobuf)  # no IN_LIST: CMP0057
if(NOT paddock_protobuf EQUAL -1)
  include("${CMAKE_CURRENT_LIST_DIR}/../../src/standins/gazebo_dev/cmake/gazebo-protobuf.cmake")
endif()
unset(paddock_protobuf)
if(CMAKE_VERSION VERSION_LESS 3.19)
  return()  # no DEFER
endif()
# Messages of a package of src/ that package.xml forgets, so that it may be configured later: what
# find_package() needs of it, without the targets that it will make.
foreach(each IN LISTS "paddock_help_${CMAKE_CURRENT_SOURCE_DIR}")
  if(each MATCHES "^messages_(.+)")
    set(name "${CMAKE_MATCH_1}")
    set(folder "${CMAKE_BINARY_DIR}/forgotten/${name}")
    file(WRITE "${folder}/${name}Config.cmake" "set(${name}_FOUND_CATKIN_PROJECT TRUE)
set(${name}_INCLUDE_DIRS \"${CATKIN_DEVEL_PREFIX}/include\")
set(${name}_LIBRARIES)
set(${name}_EXPORTED_TARGETS ${name}_generate_messages_cpp ${name}_generate_messages_py)
")
    set(${name}_DIR "${folder}")
    cmake_language(DEFER CALL unset ${name}_DIR CACHE)
  endif()
endforeach()
cmake_language(DEFER CALL paddock_help_targets
  "${CMAKE_CURRENT_SOURCE_DIR}" "${paddock_help_${CMAKE_CURRENT_SOURCE_DIR}}")

function(paddock_help_targets folder help)
  get_property(below DIRECTORY "${folder}" PROPERTY SUBDIRECTORIES)
  foreach(each IN LISTS below)
    paddock_help_targets("${each}" "${help}")
  endforeach()
  get_property(targets DIRECTORY "${folder}" PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type MATCHES "EXECUTABLE|SHARED_LIBRARY|STATIC_LIBRARY|MODULE_LIBRARY|OBJECT_LIBRARY")
      paddock_help_target(${target} "${type}" "${help}")
    endif()
  endforeach()
endfunction()

function(paddock_include_first target header)
  set_property(TARGET ${target} APPEND PROPERTY COMPILE_OPTIONS
    "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-include ${header}>")
endfunction()

function(paddock_help_target target type help)
  foreach(each IN LISTS help)
    if(each STREQUAL "placeholders")
      set_property(TARGET ${target} APPEND PROPERTY COMPILE_OPTIONS
        "$<$<COMPILE_LANGUAGE:CXX>:-DBOOST_BIND_GLOBAL_PLACEHOLDERS>")
      paddock_include_first(${target} "boost/bind.hpp")
    elseif(each STREQUAL "headers")
      set_property(TARGET ${target} APPEND PROPERTY INCLUDE_DIRECTORIES "${PADDOCK_HEADERS}")
    elseif(each STREQUAL "ffmpeg")
      set_property(TARGET ${target} APPEND PROPERTY COMPILE_OPTIONS
        "$<$<COMPILE_LANGUAGE:CXX>:-fpermissive>")
      paddock_include_first(${target} "${PADDOCK_FIRST}/before_ffmpeg_5.h")
    elseif(each STREQUAL "eigen")
      paddock_include_first(${target} "${PADDOCK_FIRST}/floating_indices.h")
    elseif(each STREQUAL "glog")
      paddock_include_first(${target} "${PADDOCK_FIRST}/before_glog_0_6.h")
    elseif(each MATCHES "^include_(.+)")
      paddock_include_first(${target} "boost/${CMAKE_MATCH_1}.hpp")
    elseif(each STREQUAL "standard")
      set_property(TARGET ${target} APPEND PROPERTY COMPILE_OPTIONS
        "$<$<COMPILE_LANGUAGE:CXX>:-std=gnu++17>")
      set_property(TARGET ${target} PROPERTY CXX_STANDARD 17)
    elseif(each MATCHES "^(protobuf|pluginlib)$")
    elseif(each MATCHES "^messages_(.+)")
      add_dependencies(${target} ${CMAKE_MATCH_1}_generate_messages_cpp)
    elseif(type MATCHES "EXECUTABLE|SHARED_LIBRARY|MODULE_LIBRARY")
      set_property(TARGET ${target} APPEND PROPERTY LINK_LIBRARIES ${each})
    endif()
  endforeach()
endfunction()
