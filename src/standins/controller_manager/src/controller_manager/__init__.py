"""Clients of a controller manager: spawner, unspawner, command line."""
