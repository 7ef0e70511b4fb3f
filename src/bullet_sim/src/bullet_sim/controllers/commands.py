"""Checks of commands."""

from bullet_sim.errors import CommandError

MAX_COMMAND = 1e9  # larger commands [rad/s, m/s, rad, m, N m, N] are refused


def check_command(name, values, counts):
    """Check a command.

    Args:
        name: controller name.
        values: sequence of numbers [rad/s, m/s, rad, m, N m, N].
        counts: how many there may be, a tuple.

    Returns:
        The values as a tuple of floats.

    Raises:
        CommandError: wrong count, NaN or beyond MAX_COMMAND.
    """
    values = tuple(float(value) for value in values)
    if len(values) not in counts:
        wanted = " or ".join(map(str, counts))
        raise CommandError(f"command of '{name}' has {len(values)} values, must have {wanted}")
    for value in values:
        if not abs(value) <= MAX_COMMAND:
            raise CommandError(
                f"command of '{name}' is {value}, must be a finite number, at most "
                f"{MAX_COMMAND:g} either way; the last good command stays"
            )
    return values
