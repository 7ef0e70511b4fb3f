"""What commands that start a launch file share: its arguments, its master, its results."""
