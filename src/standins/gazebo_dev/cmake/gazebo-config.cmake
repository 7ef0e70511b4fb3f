# Stand-in for the file by which find_package(gazebo) finds Gazebo Classic: no headers, no libraries.
# Programs that include Gazebo's headers cannot be built; those that only ask for it can.
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
