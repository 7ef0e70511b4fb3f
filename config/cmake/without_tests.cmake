# Of plain CMake packages, as BUILD_TESTING=OFF asks for and some forget: CMake includes this file after
# each project(), and programs that add_test() runs are no part of `all`.
function(add_test name)
  set(command ${ARGN})
  if(name STREQUAL "NAME")
    cmake_parse_arguments(test "" "" "COMMAND" ${ARGN})
    set(command ${test_COMMAND})
  endif()
  list(GET command 0 program)
  if(TARGET "${program}")
    set_property(TARGET "${program}" PROPERTY EXCLUDE_FROM_ALL TRUE)
  endif()
endfunction()
