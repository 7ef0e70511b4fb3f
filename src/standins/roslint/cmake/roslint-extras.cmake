# The commands that CMakeLists.txt files call; each makes the target of the usual name, which
# checks nothing.

function(_roslint_targets)
  if(NOT TARGET roslint)
    add_custom_target(roslint)
  endif()
  if(NOT TARGET roslint_${PROJECT_NAME})
    add_custom_target(roslint_${PROJECT_NAME})
    add_dependencies(roslint roslint_${PROJECT_NAME})
  endif()
endfunction()

# roslint_custom(<linter> <options> <file>...)
function(roslint_custom linter options)
  _roslint_targets()
endfunction()

# roslint_cpp([<file>...])
function(roslint_cpp)
  _roslint_targets()
endfunction()

# roslint_python([<file>...])
function(roslint_python)
  _roslint_targets()
endfunction()

# roslint_add_test()
function(roslint_add_test)
  _roslint_targets()
endfunction()
