"""What models do and measure beside their controllers: drives, sensors. Each file is entered."""

from bullet_sim.registry import load_files

load_files(__name__, __path__)
