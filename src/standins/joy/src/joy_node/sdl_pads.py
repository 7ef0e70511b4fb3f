"""Pads through SDL (pygame), without a window."""

import os
import re

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("SDL_AUDIODRIVER", "dummy")
os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
os.environ.setdefault("SDL_JOYSTICK_HIDAPI", "0")  # Linux' own order of axes and buttons

import pygame  # noqa: E402  reads the variables above when it is imported


def number_of(device):
    """Number of the pad of a device name: '/dev/input/js1', 'js1' and 1 are the second.

    A link, as in /dev/input/by-id, is followed.

    Returns:
        The number, or None: the text has none. It may be a link that comes with its pad.
    """
    text = os.path.realpath(device) if str(device).startswith("/") else str(device)
    found = re.fullmatch(r"(?:.*js)?(\d+)", text)
    return int(found.group(1)) if found else None


class SdlPad:
    """One opened pad.

    Args:
        joystick: pygame.joystick.Joystick.
        gone: function -> set of the instance numbers of pads that were taken away.
    """

    def __init__(self, joystick, gone):
        self._joystick, self._gone = joystick, gone
        self.name = joystick.get_name()

    def attached(self):
        """Whether it is still connected."""
        return self._joystick.get_instance_id() not in self._gone()

    def read(self):
        """(axes, buttons, hats) as PadState.update takes them."""
        pad = self._joystick
        return (
            [pad.get_axis(i) for i in range(pad.get_numaxes())],
            [pad.get_button(i) for i in range(pad.get_numbuttons())],
            [pad.get_hat(i) for i in range(pad.get_numhats())],
        )

    def close(self):
        """Close it."""
        self._joystick.quit()


class SdlPads:
    """All pads known to SDL.

    Args:
        device: see number_of; used when name is empty.
        name: part of a pad's name; the first that has it is taken.

    Attributes:
        wanted: what is looked for, in words.
    """

    def __init__(self, device="/dev/input/js0", name=""):
        self._device, self._name = device, name
        self.wanted = f"a joystick named '{name}'" if name else f"the joystick {device}"
        self._away = set()
        pygame.display.init()
        pygame.joystick.init()

    def _gone(self):
        """Process SDL's events, which also update the numbers of the pads."""
        for event in pygame.event.get():
            if event.type == pygame.JOYDEVICEREMOVED:
                self._away.add(event.instance_id)
        return self._away

    def open(self):
        """The pad, or None if it is not connected."""
        self._gone()
        wanted = None if self._name else number_of(self._device)
        for number in range(pygame.joystick.get_count()):
            joystick = pygame.joystick.Joystick(number)
            if self._name in joystick.get_name() if self._name else number == wanted:
                self._away.discard(joystick.get_instance_id())
                return SdlPad(joystick, self._gone)
        return None

    def close(self):
        """End SDL."""
        pygame.joystick.quit()
        pygame.display.quit()
