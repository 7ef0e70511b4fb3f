find_package(gazebo QUIET CONFIG)
