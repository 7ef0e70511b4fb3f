"""Where a car is on its track, and how its run goes. No simulator, no ROS."""
