"""Draws docs/images/solver_data.png: the records of the solver and what a step does with them.

    ./run exec python docs/tools/solver_data.py

Records and their arrays are read from engine/quickstep/state.py.
"""

from __future__ import annotations

import ast
import pathlib

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot
from matplotlib.patches import FancyBboxPatch

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src/bullet_sim/src/bullet_sim/engine/quickstep/state.py"
PICTURE = ROOT / "docs" / "images" / "solver_data.png"
WIDTH, LINE, HEAD = 2.3, 0.19, 0.62
PLACES = {  # record -> (left, top) of its box
    "System": (0.0, 6.6),
    "Scene": (0.0, 4.3),
    "Contacts": (3.6, 4.3),
    "Constraints": (3.6, 6.6),
    "Blocks": (7.2, 6.6),
    "Islands": (7.2, 4.3),
}
SHOWN = {"Scene": ("shapes", "kinds", "points", "aabbs", "may_collide", "close_pairs", "solids",
                   "faces", "trees")}  # fmt: skip
ARROWS = (  # from, to (left, bottom), text at (left, bottom)
    ((2.35, 3.6), (3.55, 3.6), "broadphase,\ncollision", (2.95, 3.95)),
    ((4.75, 4.38), (4.75, 5.68), "constraints", (5.35, 5.0)),
    ((2.35, 6.0), (3.55, 6.0), "joints, pids", (2.95, 6.15)),
    ((5.95, 6.0), (7.15, 6.0), "blocks.pack", (6.55, 6.15)),
)
BACK = "iterate, unpack: velocities and poses of the bodies"


def records() -> dict[str, tuple[str, list[str]]]:
    """Of each record the first line of its docstring and the names of its arrays."""
    found = {}
    for node in ast.parse(SOURCE.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef) and node.name in PLACES:
            fields = [item.target.id for item in node.body if isinstance(item, ast.AnnAssign)]
            found[node.name] = (ast.get_docstring(node).partition("\n")[0], fields)
    return found


def box(axes, name: str, told: str, fields: list[str]) -> None:
    """A record with its arrays."""
    left, top = PLACES[name]
    shown = SHOWN.get(name, fields)
    more = len(fields) - len(shown)
    lines = [*shown, *([f"and {more} more"] if more else [])]
    height = HEAD + LINE * ((len(lines) + 1) // 2) + 0.12
    style = FancyBboxPatch(
        (left, top - height), WIDTH, height, boxstyle="round,pad=0.03", fc="#eef3f6", ec="#2f6f8f"
    )
    axes.add_patch(style)
    axes.text(left + 0.08, top - 0.2, name, weight="bold", fontsize=10)
    axes.text(left + 0.08, top - 0.42, told[:44], fontsize=6.5, color="#444")
    for index, line in enumerate(lines):
        x, y = left + 0.08 + (index % 2) * WIDTH / 2, top - HEAD - LINE * (index // 2) - 0.05
        axes.text(x, y, line, fontsize=7, family="monospace")


def main() -> None:
    """Draws the picture."""
    figure, axes = pyplot.subplots(figsize=(10, 5))
    axes.set_xlim(-0.2, 9.8)
    axes.set_ylim(2.2, 7.7)
    axes.set_axis_off()
    axes.text(0, 7.35, "descriptions (URDF, SDF)", fontsize=9)
    axes.annotate("", (1.0, 6.68), (1.0, 7.28), arrowprops={"arrowstyle": "->"})
    axes.text(1.1, 6.95, "tables, ode_arrays, ode_scene, ode_shapes", fontsize=7.5, style="italic")
    for name, (told, fields) in records().items():
        box(axes, name, told, fields)
    for start, end, text, place in ARROWS:
        axes.annotate("", end, start, arrowprops={"arrowstyle": "->", "color": "#b3541e"})
        axes.text(*place, text, fontsize=7.5, style="italic", ha="center", color="#b3541e")
    way = (9.55, 9.68, 9.68, -0.12, -0.12), (6.0, 6.0, 2.35, 2.35, 6.0)
    axes.plot(*way, color="#b3541e", lw=1)
    axes.annotate("", (0.0, 6.0), (-0.12, 6.0), arrowprops={"arrowstyle": "->", "color": "#b3541e"})
    axes.text(6.2, 2.43, BACK, fontsize=7.5, style="italic", ha="center", color="#b3541e")
    figure.tight_layout()
    figure.savefig(PICTURE, dpi=100)
    print(f"{PICTURE}: {PICTURE.stat().st_size // 1024} KB")


if __name__ == "__main__":
    main()
