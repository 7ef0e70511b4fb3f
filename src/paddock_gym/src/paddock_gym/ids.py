"""Gymnasium's ids of the environments, and their names for commands and policies."""

IDS = ("Paddock/DeepRacer-v1", "Paddock/CyberTruckBacking-v1")
ROBOT = "Paddock/Robot-v0"  # any robot, by its launch file or description
DEEPRACER, BACKING = "deepracer", "backing"
ANY_ROBOT = "robot"  # of policies for Robot-v0
ENVS = {DEEPRACER: IDS[0], BACKING: IDS[1]}
