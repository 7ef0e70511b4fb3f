"""The simulator's window. `main` is the process, started by the bridge; needs PyQt5."""
