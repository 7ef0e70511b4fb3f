"""The nodes around cybertruck.trailer: backing action, its demonstration, the steering map."""
