"""The figures as a table."""

from dataclasses import dataclass

from figures import WITHIN, Spread, call
from sections import SECTIONS, section

IDLE = 0.1  # processors that others may have on a machine that counts as idle


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        label: what it is about; the same in every run.
        value: Spread or number that is a result, see results.py; None: not.
        unit: of the value, "" for a ratio.
    """

    label: str
    text: str
    value: object = None
    unit: str = ""


def ratio_row(label, figures, of, unit):
    """The Row of a ratio, see Pairs.figures.

    Args:
        figures: what Pairs.figures gave.
    """
    ratio = Spread.read(figures["ratio"])
    text = (
        f"{ratio.text()} of {of}, {figures['pairs']} pairs, "
        f"{figures['variant']['median']:.1f} / {figures['reference']['median']:.1f} {unit}"
    )
    if figures["against_reference"] == WITHIN:
        text += f"; {WITHIN}, no difference to call"
    return Row(label, text, ratio)


def compared(figures, other, name):
    """Words for a ratio beside another one's, both as Pairs.figures gave them."""
    verdict = call(Spread.read(figures["ratio"]), Spread.read(other["ratio"]))
    return f"{verdict} of {name}" if verdict == WITHIN else f"{verdict} than {name}"


def spent_text(spent):
    """Words for usage.summarise: who had the processors; roles below a hundredth are left out."""
    roles = sorted(spent["cpu"].items(), key=lambda item: -item[1])
    text = ", ".join(f"{role} {share:.2f}" for role, share in roles if share >= 0.01) or "nobody"
    text += (
        f"; others {spent['others']:.2f} (most {spent['others_most']:.2f}), stolen "
        f"{spent['stolen']:.2f} (most {spent['stolen_most']:.2f})"
    )
    thread = spent["threads"].get("simulation")
    if thread:
        text += (
            f"; simulation thread switched off {thread['switched_off']:.0f} times a second, "
            f"ready but without a processor {100 * thread['waited']:.0f} % of the time"
        )
    return text


def busiest(result):
    """The most processors that others had or that were stolen, a median of some figure's rounds."""
    values = result.values() if isinstance(result, dict) else result
    found = [busiest(value) for value in values if isinstance(value, (dict, list))]
    own = []
    if isinstance(result, dict) and "others" in result:
        own = [result["others"] + result["stolen"]]
    return max(found + own, default=0.0)


def rows_of(result):
    """The Rows of a result, section by section."""
    for name in SECTIONS:
        if name in result:
            yield from section(name).rows(result[name])


def table(result):
    """The table's text."""
    load = "/".join(f"{value:.1f}" for value in result["load_average"])
    lines = [f"{row.label:35} {row.text}" for row in rows_of(result)]
    lines += [f"{name} FAILED".ljust(36) + error for name, error in result["errors"].items()]
    lines.append(f"load average before {load} on {result['machine']['cores']} processors")
    if busiest(result) > IDLE:
        lines.append(
            f"others had up to {busiest(result):.2f} processors meanwhile: this was no idle "
            "machine, the figures are disturbed"
        )
    if result["quick"]:
        lines.append("a quick run: fewer pairs in shorter rounds; its figures are not to be quoted")
    return "\n".join(lines)
