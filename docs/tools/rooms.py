"""Draws docs/images/rooms.png: packages, their folders and imports, as the sources have them."""

import ast
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot
from matplotlib.patches import FancyBboxPatch

ROOT = pathlib.Path(__file__).resolve().parents[2]
# package -> (column, row) of its box's lower left corner
PLACES = {
    "bullet_sim": (0.0, 0.0),
    "bullet_bridge": (3.3, 0.0),
    "bullet_web": (6.6, 0.0),
    "bullet_gazebo_host": (10.05, 0.0),
    "paddock_common": (0.0, 3.4),
    "track_model": (1.65, 3.4),
    "deepracer_control": (3.3, 3.4),
    "deepracer_teleop": (4.95, 3.4),
    "cybertruck": (6.6, 3.4),
    "paddock_gym": (8.25, 1.3),
    "paddock_navigation": (10.05, 3.4),
}
WIDTH, HEIGHT, LINE = 1.45, 3.0, 0.17
TALL = {"paddock_gym": 3.8}
WIDE = {"bullet_sim": 2 * WIDTH, "bullet_bridge": 2 * WIDTH, "paddock_navigation": 1.75}
ROWS = 14  # of folders in a column; more go into the next


def folder_of(package):
    """The package's Python folder."""
    return ROOT / "src" / package / "src" / package


def rooms(package):
    """(name, number of modules) of the package's folders; its top comes first."""
    base = folder_of(package)
    if not base.is_dir():
        return []
    found = [("", len([path for path in base.glob("*.py") if path.name != "__init__.py"]))]
    for path in sorted(base.rglob("__init__.py")):
        if path.parent != base:
            modules = [other for other in path.parent.glob("*.py") if other != path]
            found.append((str(path.parent.relative_to(base)) + "/", len(modules)))
    return found


def contents(package):
    """What a package has that has no Python."""
    return "C++" if list((ROOT / "src" / package).rglob("*.cc")) else "launch files"


def imported(package):
    """Packages of ours that a package imports."""
    names = set()
    for path in folder_of(package).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module.split(".")[0])
    return sorted(names & set(PLACES) - {package})


def draw(axes, package):
    """A box with the package's name and folders."""
    x, y = PLACES[package]
    wide = WIDE.get(package, WIDTH)
    high = TALL.get(package, HEIGHT)
    axes.add_patch(
        FancyBboxPatch(
            (x, y), wide, high, "round,pad=0.02", facecolor="#eef2f6", edgecolor="#37474f"
        )
    )
    axes.text(x + 0.08, y + high - 0.2, package, weight="bold", fontsize=10)
    for number, (name, count) in enumerate(rooms(package) or [(contents(package), "")]):
        column, row = divmod(number, ROWS)
        place = (x + 0.12 + WIDTH * column, y + high - 0.45 - LINE * row)
        axes.text(*place, f"{name or '(top)'}  {count}", fontsize=8, color="#263238")
    others = imported(package)
    for number, name in enumerate(others):
        place = (x + 0.08, y + 0.1 + LINE * (len(others) - 1 - number))
        axes.text(*place, f"imports {name}", fontsize=8, color="#b71c1c")


def main():
    """Writes the picture."""
    figure, axes = pyplot.subplots(figsize=(17.4, 8.6))
    for package in PLACES:
        draw(axes, package)
    axes.text(0.0, 6.55, "robot packages: no import of the simulator", fontsize=9, style="italic")
    axes.text(8.25, 5.25, "learning", fontsize=9, style="italic")
    axes.text(0.0, -0.3, "simulator; numbers: modules in a folder", fontsize=9, style="italic")
    axes.set(xlim=(-0.2, 12.0), ylim=(-0.6, 6.8))
    axes.axis("off")
    target = ROOT / "docs" / "images" / "rooms.png"
    figure.savefig(target, dpi=90, bbox_inches="tight")
    print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main())
