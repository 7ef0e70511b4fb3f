"""Pads through SDL (pygame), without a window."""

import os
import re

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("SDL_AUDIODRIVER", "dummy")
os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
os.environ.setdefault("SDL_JOYSTICK_HIDAPI", "0")  # Linux' own order of axes and buttons

import pygame  # noqa: E402  reads the variables above when it is imported


def index_of(device):
    """Index of the pad of a device name: '/dev/input/js1', 'js1' and 1 are the second.

    A link, as in /dev/input/by-id, is followed.

    Returns:
        The index, or None: the text has none. It may be a link that appears with its pad.
    """
    text = os.path.realpath(device) if str(device).startswith("/") else str(device)
    match = re.fullmatch(r"(?:.*js)?(\d+)", text)
    return int(match.group(1)) if match else None


class SdlPad:
    """One opened pad.

    Args:
        removed: function -> set of the instance IDs of disconnected pads.
    """

    def __init__(self, joystick, removed):
        self._joystick, self._removed = joystick, removed
        self.name = joystick.get_name()

    def attached(self):
        return self._joystick.get_instance_id() not in self._removed()

    def read(self):
        """(axes, buttons, hats) for PadState.update."""
        pad = self._joystick
        return (
            [pad.get_axis(i) for i in range(pad.get_numaxes())],
            [pad.get_button(i) for i in range(pad.get_numbuttons())],
            [pad.get_hat(i) for i in range(pad.get_numhats())],
        )

    def close(self):
        self._joystick.quit()


class SdlPads:
    """All pads known to SDL.

    Args:
        device: see index_of; used when name is empty.
        name: part of a pad's name; the first that has it is used.

    Attributes:
        label: name of the pad for the log.
    """

    def __init__(self, device="/dev/input/js0", name=""):
        self._device, self._name = device, name
        self.label = f"a joystick named '{name}'" if name else f"the joystick {device}"
        self._away = set()
        pygame.display.init()
        pygame.joystick.init()

    def _removed(self):
        """Process SDL's events, which also update the indices of the pads."""
        for event in pygame.event.get():
            if event.type == pygame.JOYDEVICEREMOVED:
                self._away.add(event.instance_id)
        return self._away

    def open(self):
        """The pad, or None if it is not connected."""
        self._removed()
        device_index = None if self._name else index_of(self._device)
        for index in range(pygame.joystick.get_count()):
            joystick = pygame.joystick.Joystick(index)
            if self._name in joystick.get_name() if self._name else index == device_index:
                self._away.discard(joystick.get_instance_id())
                return SdlPad(joystick, self._removed)
        return None

    def close(self):
        pygame.joystick.quit()
        pygame.display.quit()
