"""Gymnasium's ids of the environments, and their names for commands and policies."""

IDS = ("Paddock/DeepRacer-v0", "Paddock/CyberTruckBacking-v0")
DEEPRACER, BACKING = "deepracer", "backing"
ENVS = {DEEPRACER: IDS[0], BACKING: IDS[1]}
