"""Command line make_track."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from track_model import source, spec
from track_model.files import cache


def command_line() -> argparse.ArgumentParser:
    """The command's options."""
    parser = argparse.ArgumentParser(prog="make_track", description="Build a track from its file.")
    parser.add_argument(
        "track",
        help="default, easy, medium, hard, or the path of a YAML file or of a route (.npy, .csv)",
    )
    parser.add_argument("--sdf", action="store_true", help="print the SDF model, nothing else")
    parser.add_argument(
        "--walls", action="store_true", help="with --sdf: walls along the lane in any case"
    )
    parser.add_argument(
        "-o", "--output", metavar="DIR", help="write the files there and not into the cache"
    )
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Print a track's SDF or write its files; returns the exit code.

    Errors are one line on stderr and exit code 1.
    """
    parser = command_line()
    arguments = parser.parse_args(argv)
    if arguments.walls and not arguments.sdf:
        parser.error("--walls is for --sdf")
    try:
        path = source.find(arguments.track)
        if arguments.output:
            paths = cache.export(path, arguments.output)
        else:
            directory = cache.ensure(path)
            paths = [os.path.join(directory, name) for name in cache.FILES]
        if arguments.walls:
            # numpy and OpenCV, which a cached answer does without
            from track_model.track import load_track

            sys.stdout.write(load_track(arguments.track, walls=True).sdf())
        elif arguments.sdf:
            with open(paths[cache.FILES.index("track.sdf")], encoding="utf-8") as stream:
                sys.stdout.write(stream.read())
        else:
            print("\n".join(paths))
        return 0
    except spec.TrackError as error:
        print(f"make_track: {error}", file=sys.stderr)
    except ImportError as error:
        print(
            f"make_track: {error}; numpy, scipy, shapely and OpenCV (cv2) are needed to build "
            "a track",
            file=sys.stderr,
        )
    except OSError as error:
        print(
            f"make_track: {error.filename or arguments.track}: {error.strerror or error}",
            file=sys.stderr,
        )
    return 1
