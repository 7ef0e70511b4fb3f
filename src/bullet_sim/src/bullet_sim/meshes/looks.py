"""Colours and pictures of meshes; Pillow is loaded on demand."""

import os
import warnings

import numpy as np

from bullet_sim.errors import ModelError

WHITE = (1.0, 1.0, 1.0, 1.0)
MAX_PIXELS = 8192 * 8192
_MOST = f"must have at most {MAX_PIXELS} (as 8192 x 8192 has)"
GREY = (0.7, 0.7, 0.7, 1.0)  # of parts without a colour


class TooLarge(ModelError):
    """A picture has too many pixels."""


def rgba(color):
    """RGBA 0..1 of trimesh's colour of 0..255, which may lack the last number."""
    return tuple(float(value) / 255.0 for value in (list(color) + [255])[:4])


def picture_of(material):
    """Pillow picture over a trimesh's material, or None."""
    return getattr(material, "image", None) or getattr(material, "baseColorTexture", None)


def opened(source):
    """Pillow picture of a file, not read yet; to be closed.

    Args:
        source: path, or a binary stream with a name.

    Raises:
        ModelError: it is no picture, or has more than MAX_PIXELS.
    """
    from PIL import Image

    path = getattr(source, "name", source)
    if source is path and not os.path.isfile(path):
        raise ModelError(f"picture '{path}' cannot be read: it is no file")
    try:
        with warnings.catch_warnings():  # of Pillow, which has a bound of its own
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(source)
    except Image.DecompressionBombError as error:
        raise TooLarge(f"picture '{path}' has too many pixels, {_MOST}") from error
    except (OSError, ValueError, SyntaxError) as error:
        raise ModelError(f"picture '{path}' cannot be read: {error}") from error
    width, height = picture.size
    if width * height > MAX_PIXELS:
        picture.close()
        raise TooLarge(f"picture '{path}' has {width} x {height} pixels, {_MOST}")
    return picture


def open_picture(path, transparent=False):
    """Pillow picture of a file, with its transparency if wanted and there.

    Raises:
        ModelError: it cannot be read.
    """
    try:
        with opened(path) as found:
            return found.convert("RGBA" if transparent and "A" in found.getbands() else "RGB")
    except ModelError:
        raise
    except (OSError, ValueError, SyntaxError) as error:
        raise ModelError(f"picture '{path}' cannot be read: {error}") from error


def mean_color(path):
    """Mean RGBA of a picture file."""
    mean = np.asarray(open_picture(path).resize((32, 32))).reshape(-1, 3).mean(axis=0)
    return tuple((mean / 255.0).tolist()) + (1.0,)
