"""Configuration types, as dynamic_reconfigure servers take them."""
