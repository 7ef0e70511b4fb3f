"""Checks of the car's motion: printed, and stored for the result."""

import math


class Checks:
    """A list of checks.

    Attributes:
        results: Dicts with what, measured, low, high, unit, ok.
    """

    def __init__(self):
        self.results = []

    def add(self, what, measured, low, high, unit):
        """Prints and stores one check: low <= measured <= high."""
        passed = bool(low <= measured <= high)
        self.results.append(
            {
                "what": what,
                "measured": round(measured, 5),
                "low": low,
                "high": high,
                "unit": unit,
                "ok": passed,
            }
        )
        ends = [
            "-inf" if low == -math.inf else f"{low:.3f}",
            f"{high:.3f}" if high < math.inf else "inf",
        ]
        print(
            f"demo: {what:<38} {measured:+8.3f} {unit:<5} expected {ends[0]} .. {ends[1]}  "
            f"{'ok' if passed else 'FAILED'}",
            flush=True,
        )

    @property
    def passed(self):
        """Number of checks that passed."""
        return sum(check["ok"] for check in self.results)

    @property
    def all_passed(self):
        """Whether every check passed."""
        return self.passed == len(self.results)
