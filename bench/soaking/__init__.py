"""Hours of faults: what is started, what is done to it, what is monitored, what is reported."""
