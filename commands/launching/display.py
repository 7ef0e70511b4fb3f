"""Whether a window can open."""

from commands.errors import CommandError


def has_display(environ):
    """Says whether there is a screen to open a window on."""
    return bool(environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY"))


def need_display(environ, instead):
    """Refuses to open a window where there is no screen.

    Args:
        environ: Its variables tell; QT_QPA_PLATFORM says that somebody knows what he does.
        instead: A command that needs none.

    Raises:
        CommandError: There is no screen.
    """
    if not has_display(environ) and not environ.get("QT_QPA_PLATFORM"):
        raise CommandError(
            "the window needs a display, and neither DISPLAY nor WAYLAND_DISPLAY is set",
            f"Without one: {instead}",
        )
