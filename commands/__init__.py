"""What ./run does once Debian's python3 is there: set-up, environment, and one file per command.

Only the standard library is used, since set-up runs before .venv exists; modules are imported
where they are needed, because every millisecond here is paid by each ./run exec.
"""
