# Helps old C++ of packages that a user has put into src/. CMake includes this file after each
# project(); ./run writes PADDOCK_HELP, which sets for the folder of each such package what it needs:
# a list of placeholders, headers, standard, boost_NAME. Packages that need nothing are left alone.

if(NOT DEFINED PADDOCK_HELP OR NOT EXISTS "${PADDOCK_HELP}")
  return()
endif()
include("${PADDOCK_HELP}")
if(NOT DEFINED "paddock_help_${CMAKE_CURRENT_SOURCE_DIR}")
  return()
endif()
if(CMAKE_VERSION VERSION_LESS 3.19)
  return()  # no DEFER
endif()
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

function(paddock_help_target target type help)
  foreach(each IN LISTS help)
    if(each STREQUAL "placeholders")
      set_property(TARGET ${target} APPEND PROPERTY COMPILE_OPTIONS
        "$<$<COMPILE_LANGUAGE:CXX>:-DBOOST_BIND_GLOBAL_PLACEHOLDERS>"
        "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-include boost/bind.hpp>")
    elseif(each STREQUAL "headers")
      set_property(TARGET ${target} APPEND PROPERTY INCLUDE_DIRECTORIES "${PADDOCK_HEADERS}")
    elseif(each STREQUAL "standard")
      set_property(TARGET ${target} APPEND PROPERTY COMPILE_OPTIONS
        "$<$<COMPILE_LANGUAGE:CXX>:-std=gnu++17>")
      set_property(TARGET ${target} PROPERTY CXX_STANDARD 17)
    elseif(type MATCHES "EXECUTABLE|SHARED_LIBRARY|MODULE_LIBRARY")
      set_property(TARGET ${target} APPEND PROPERTY LINK_LIBRARIES ${each})
    endif()
  endforeach()
endfunction()
