"""Errors of the core: each names the item, the value and what would be valid."""


class SimError(ValueError):
    """Base class of errors caused by bad input."""


class ModelError(SimError):
    """A robot or object description cannot be loaded."""


class WorldError(SimError):
    """A world file or a request to the world is wrong."""


class ControllerError(SimError):
    """A controller's configuration or a switch of controllers is wrong."""


class CommandError(SimError):
    """A command value is not usable."""


class RenderError(SimError):
    """Images cannot be rendered as requested."""
