"""Messages and services of controller managers; utils finds and filters them."""
