"""The test run: a table of jobs, run side by side, and one sum at the end."""
