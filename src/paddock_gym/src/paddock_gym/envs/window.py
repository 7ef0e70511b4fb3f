"""The window of render_mode human, by pygame as Gymnasium's own."""

from typing import Any

import numpy as np

from paddock_gym.errors import GymError


class Window:
    """Shows images at the control rate."""

    def __init__(self) -> None:
        try:
            import pygame
        except ImportError as error:
            raise GymError("render_mode human needs pygame, which is not installed") from error
        self._pygame = pygame
        self._screen: Any = None

    def show(self, image: np.ndarray, rate: float) -> None:
        """Show an image (H, W, 3) uint8 RGB and wait for the next period of a rate [Hz]."""
        pygame = self._pygame
        size = image.shape[1], image.shape[0]
        if self._screen is None:
            pygame.display.init()
            pygame.display.set_caption("Paddock")
            self._screen = pygame.display.set_mode(size)
            self._clock = pygame.time.Clock()
        # surfarray asks numpy for names that a newer one than pygame's own does not have
        surface = pygame.image.frombuffer(image.tobytes(), size, "RGB")
        self._screen.blit(surface, (0, 0))
        pygame.event.pump()
        pygame.display.flip()
        self._clock.tick(rate)

    def close(self) -> None:
        """Close the window."""
        if self._screen is not None:
            self._pygame.display.quit()
            self._screen = None
