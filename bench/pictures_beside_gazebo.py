"""Images of cameras in Gazebo and in Paddock side by side, with figures, as a page.

    ./run exec python bench/pictures_beside_gazebo.py [CASES] [--gazebo FILE.npz] [--page PAGE.html]
        [--sheet FILE.png]

Without arguments: a world with one place for each feature of cameras is rendered here and compared
with what is recorded of Gazebo 11.1. CASES is a folder with images of public packages, named
NAME.gazebo_TOPIC.png and NAME.paddock_TOPIC.png (or .ppm). To look at Gazebo's images of the world,
too, or to record them again:

    ./run exec python bench/pictures_beside_gazebo.py --world FOLDER       writes features.world
    roslaunch gazebo_ros empty_world.launch world_name:=FOLDER/features.world gui:=false
    python3 bench/pictures/record.py FILE.npz                              where Gazebo runs
    ./run exec python bench/pictures_beside_gazebo.py --gazebo FILE.npz [--update]

The exit code is 1 when a pair is not alike: similarity of at least 0.90 (or, where only numbers are
recorded, 90 % of the cells of 16 x 16 pixels within 4 of 255), means within 4 of 255, depths within
5 mm.
"""

import argparse
import base64
import html
import json
import pathlib
import sys
import tempfile

import cv2
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from pictures import features, likeness  # noqa: E402

DEPTHS = 0.99  # share of depths that must be alike
STYLE = (
    "body{font:15px sans-serif;margin:2em;max-width:72em}img{max-width:100%}"
    "table{border-collapse:collapse}td,th{padding:.3em .8em;text-align:left;vertical-align:top}"
    "tr{border-top:1px solid #ccc}.no{color:#b00}"
)


class InputError(ValueError):
    """What was given cannot be compared."""


def read_image(path):
    """(H, W, 3) uint8 RGB of an image file."""
    image = cv2.imread(str(path))
    if image is None:
        raise InputError(f"'{path}' is no image that can be read")
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


def case_pairs(folder):
    """Pairs of public packages.

    Returns:
        dict: name -> (Pair, Gazebo's image, Paddock's).
    """
    folder = pathlib.Path(folder)
    if not folder.is_dir():
        raise InputError(f"'{folder}' is no folder")
    found = {}
    for theirs in sorted(folder.glob("*.gazebo_*.p[np][gm]")):
        stem = theirs.stem.replace(".gazebo_", ".paddock_")
        ours = [path for path in folder.glob(f"{stem}.p[np][gm]")]
        if not ours:
            continue
        one, other = read_image(theirs), read_image(ours[0])
        if one.shape != other.shape:
            raise InputError(f"'{theirs}' and '{ours[0]}' have sizes {one.shape}, {other.shape}")
        found[theirs.stem.replace(".gazebo_", " ")] = likeness.pair_of(one, other), one, other
    if not found:
        raise InputError(f"'{folder}' has no pair NAME.gazebo_TOPIC.png, NAME.paddock_TOPIC.png")
    return found


def feature_pairs(gazebo=None):
    """Pairs of the world's places.

    Args:
        gazebo: name -> features.Seen of Gazebo; empty: what is recorded.

    Returns:
        dict: name -> (Pair, Gazebo's image or None, Paddock's).
    """
    records = likeness.recorded()
    with tempfile.TemporaryDirectory() as folder:
        features.write(folder)
        ours = features.render(folder)
    pairs = {}
    for name, seen in ours.items():
        if gazebo:
            if name not in gazebo:
                raise InputError(f"Gazebo's images have no '{name}'")
            pair = likeness.recorded_pair(likeness.record_of(gazebo[name]), seen)
            alike = likeness.similarity(gazebo[name].rgb, seen.rgb)
            alike = None if features.PLACES[name].noise else alike
            pair = likeness.Pair(pair.means, pair.cells, alike, pair.depth)
            pairs[name] = pair, gazebo[name].rgb, seen.rgb
        else:
            pairs[name] = likeness.recorded_pair(records[name], seen), None, seen.rgb
    return pairs


def places_of(names):
    """Names of places, separated by commas; None: all of them."""
    chosen = names.split(",") if names else list(features.PLACES)
    unknown = [name for name in chosen if name not in features.PLACES]
    if unknown:
        raise InputError(f"--only has '{unknown[0]}', the places are {', '.join(features.PLACES)}")
    return chosen


def read_recordings(paths):
    """features.Seen by place of files of pictures/record.py."""
    arrays = {}
    for path in paths:
        try:
            arrays.update(np.load(path))
        except (OSError, ValueError) as error:
            raise InputError(f"'{path}' is no recording: {error}") from None
    return {
        name: features.Seen(arrays[name], arrays.get(f"{name}_depth"), arrays.get(f"{name}_points"))
        for name in features.PLACES
        if name in arrays
    }


def is_alike(pair):
    """Whether a pair is alike, depths included."""
    return pair.alike and (pair.depth is None or (pair.depth[0] >= DEPTHS and pair.depth[1] < 0.01))


def figures_text(pair):
    """The figures of a pair in words."""
    one, other = (" ".join(f"{value:.0f}" for value in mean) for mean in pair.means)
    text = f"means {one} | {other}, cells within 4: {100 * pair.cells[1]:.0f} %"
    text += f", greatest difference {pair.cells[0]:.0f}"
    if pair.similarity is not None:
        text = f"similarity {pair.similarity:.3f}, {text}"
    if pair.depth is not None:
        text += f"; depths within 5 mm: {100 * pair.depth[0]:.1f} %"
        text += f", unknown in one alone: {100 * pair.depth[1]:.1f} %"
    return text


def page(parts):
    """HTML of the pairs.

    Args:
        parts: title -> pairs as case_pairs returns them.
    """
    body = ""
    for title, pairs in parts.items():
        good = sum(is_alike(pair) for pair, _, _ in pairs.values())
        body += f"<h2>{html.escape(title)}: {good} of {len(pairs)} alike</h2><table>"
        body += "<tr><th>camera<th>Gazebo<th>Paddock</tr>"
        for name, (pair, one, other) in pairs.items():
            kind = "" if is_alike(pair) else " class=no"
            body += f"<tr><td{kind}><b>{html.escape(name)}</b><br>{figures_text(pair)}"
            body += f"<td>{_image(one)}<td>{_image(other)}</tr>"
        body += "</table>"
    return f"<!doctype html><meta charset=utf-8><title>Images</title><style>{STYLE}</style>{body}\n"


def _image(rgb):
    if rgb is None:
        return "recorded as numbers"
    _, data = cv2.imencode(".png", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR))
    return f"<img src='data:image/png;base64,{base64.b64encode(data).decode()}'>"


def sheet(pairs, columns=2):
    """RGB image of the pairs that have both images, Gazebo's on the left.

    Raises:
        InputError: there is none.
    """
    both = {name: pair[1:] for name, pair in pairs.items() if pair[1] is not None}
    if not both:
        raise InputError("--sheet needs images of Gazebo: CASES or --gazebo FILE")
    height, width = 240, 320
    tiles = []
    for name, images in both.items():
        tile = np.full((height + 34, 2 * width + 16, 3), 255, np.uint8)
        for place, image in enumerate(images):
            small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
            tile[24 : 24 + height, place * (width + 4) : place * (width + 4) + width] = small
        cv2.putText(tile, name.replace("_", " "), (2, 17), 0, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
        tiles.append(tile)
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % columns)
    rows = [np.hstack(tiles[at : at + columns]) for at in range(0, len(tiles), columns)]
    return np.vstack(rows)


def main(arguments=None):
    """Compare; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cases", nargs="?", help="folder with images of public packages")
    parser.add_argument(
        "--gazebo", metavar="FILE", nargs="+", help="recordings of the world in Gazebo"
    )
    parser.add_argument(
        "--update", action="store_true", help="take it as what is recorded, place by place"
    )
    parser.add_argument("--page", metavar="FILE", help="write the pairs as HTML")
    parser.add_argument("--sheet", metavar="FILE", help="write both images of each pair as PNG")
    parser.add_argument("--world", metavar="FOLDER", help="write the world there, nothing else")
    parser.add_argument(
        "--only", metavar="NAMES", help="places of it, separated by commas; default: all"
    )
    parser.add_argument("--seen-as", metavar="FOLDER", help="its path where it will be loaded")
    chosen = parser.parse_args(arguments)
    try:
        if chosen.update and not chosen.gazebo:
            raise InputError("--update needs --gazebo FILE")
        if chosen.world:
            print(features.write(chosen.world, chosen.seen_as, places_of(chosen.only)))
            return 0
        parts = {"Public packages": case_pairs(chosen.cases)} if chosen.cases else {}
        gazebo = read_recordings(chosen.gazebo) if chosen.gazebo else None
        if chosen.update:
            places = likeness.recorded()  # of the others, what is there
            places.update({name: likeness.record_of(seen) for name, seen in gazebo.items()})
            likeness.RECORDED.write_text(json.dumps({"places": places}) + "\n")
        parts["World of features"] = feature_pairs(gazebo)
        if chosen.sheet:
            every = {name: pair for pairs in parts.values() for name, pair in pairs.items()}
            cv2.imwrite(chosen.sheet, cv2.cvtColor(sheet(every), cv2.COLOR_RGB2BGR))
    except (InputError, OSError) as error:
        print(f"pictures_beside_gazebo: {error}", file=sys.stderr)
        return 2
    for title, pairs in parts.items():
        for name, (pair, _, _) in pairs.items():
            print(f"{'alike ' if is_alike(pair) else 'differ'} {name}: {figures_text(pair)}")
        good = sum(is_alike(pair) for pair, _, _ in pairs.values())
        print(f"{title}: {good} of {len(pairs)} alike")
    if chosen.page:
        pathlib.Path(chosen.page).write_text(page(parts))
    return int(any(not is_alike(pair) for pairs in parts.values() for pair, _, _ in pairs.values()))


if __name__ == "__main__":
    sys.exit(main())
