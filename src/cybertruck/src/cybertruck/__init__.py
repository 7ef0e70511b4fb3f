"""Cyber Truck and trailer: drive node, odometry, teleops, goal and backing controllers."""
