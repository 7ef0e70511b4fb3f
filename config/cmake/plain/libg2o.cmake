# g2o without its programs, which need OpenGL and Qt's old viewer.
foreach(name IN ITEMS G2O_BUILD_APPS G2O_BUILD_EXAMPLES G2O_USE_OPENGL)
  set(${name} OFF CACHE BOOL "")
endforeach()
