"""The services that read and change physics: gazebo_msgs' and dynamic_reconfigure's."""
