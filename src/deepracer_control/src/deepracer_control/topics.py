"""Every topic name of the car's stack; change this file to point the stack at another car."""

# Sensors
CAMERA_TOPIC = "/camera/image"
ODOMETRY_TOPIC = "/racecar/odom"

# Wheel speeds [rad/s], std_msgs/Float64
RIGHT_REAR_TOPIC = "/racecar/right_rear_wheel_velocity_controller/command"
LEFT_REAR_TOPIC = "/racecar/left_rear_wheel_velocity_controller/command"
RIGHT_FRONT_TOPIC = "/racecar/right_front_wheel_velocity_controller/command"
LEFT_FRONT_TOPIC = "/racecar/left_front_wheel_velocity_controller/command"

# Steering hinge angles [rad], positive to the left, std_msgs/Float64
LEFT_DIRECTION_TOPIC = "/racecar/left_steering_hinge_position_controller/command"
RIGHT_DIRECTION_TOPIC = "/racecar/right_steering_hinge_position_controller/command"

# Command of the car, geometry_msgs/Twist
COMMANDED_DATA_TOPIC = "/cmd_vel"

# A gamepad, if there is one, sensor_msgs/Joy
PAD_TOPIC = "/joy"
