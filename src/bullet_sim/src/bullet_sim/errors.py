"""Errors of the core: each names the item, the value and what would be valid."""

from __future__ import annotations

import functools
from typing import Any, Callable, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])
# What numbers beyond all bounds, endless nesting and missing files raise, besides SimErrors.
BROKEN = (ArithmeticError, TypeError, ValueError, OSError, RecursionError, MemoryError)


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


def reads(function: Function) -> Function:
    """Decorator of a reader (text, resolve, label): what is wrong in the text is a ModelError."""

    @functools.wraps(function)
    def read(*args: Any, **options: Any) -> Any:
        try:
            return function(*args, **options)
        except SimError:
            raise
        except BROKEN as error:
            label = args[2] if len(args) > 2 else options.get("label", "the description")
            raise ModelError(
                f"'{label}' cannot be read: {type(error).__name__}: {error}"
            ) from error

    return cast(Function, read)
