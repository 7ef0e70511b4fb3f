"""Messages between the render client and its worker: picklable values."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from bullet_sim.description.model import VISIBLE
from bullet_sim.pose import Array, PoseTuple

RENDERERS = ("auto", "gl", "tiny")
SWITCHES = ("auto", "true", "false")


@dataclass(frozen=True)
class Lens:
    """r = c1 f function(theta / c2 + c3), with r = 1 at half the image's width.

    Attributes:
        fov: horizontal field of view [rad], up to 2 pi.
        function: 'tan', 'sin' or 'id'.
        scaled: f is chosen such that `fov` fills the width.
        cutoff: maximum angle from the axis that is visible [rad].
        texture: edge of the six images, around the camera, of which its image is made [px].
    """

    fov: float
    c1: float = 1.0
    c2: float = 1.0
    c3: float = 0.0
    f: float = 1.0
    function: str = "id"
    scaled: bool = True
    cutoff: float = math.pi
    texture: int = 256


@dataclass(frozen=True)
class Distortion:
    """Distortion of an image, see lenses.

    Attributes:
        k1, k2, k3, p1, p2: coefficients of Brown's model.
        center: of the lens, in widths and heights of the image from its upper left corner.
        crop: whether the image is enlarged until its corners are filled.
        legacy: whether coordinates are in image sizes, as by default in Gazebo; False: in focal
            lengths.
    """

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    center: tuple[float, float] = (0.5, 0.5)
    crop: bool = False
    legacy: bool = True


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole's projection [px]: column fx x/z - s y/z + cx and row fy y/z + cy of a point of the
    optical frame, from the corner of the image.
    """

    fx: float = 277.0
    fy: float = 277.0
    cx: float = 160.0
    cy: float = 120.0
    s: float = 0.0


@dataclass(frozen=True)
class CameraRequest:
    """One camera as the worker needs it.

    Attributes:
        name: unique among the cameras; frames carry it.
        key: BodySource.key of the body that carries the camera; None: the pose is in the world.
        link_index: row of Engine.link_poses: 0 is the root link, so Engine.link_indices + 1.
        pose: (xyz (3,) [m], rpy (3,) [rad]), camera frame (x forward, z up) in the link frame.
        width, height: [px].
        horizontal_fov: [rad].
        near, far: clip distances [m].
        noise_stddev, noise_mean: of the full scale, see sensors.camera.add_noise.
        seed: of the noise; the noise of a frame depends on seed, name and step alone.
        labels: whether a label image is requested.
        visibility: the OpenGL renderer shows what has one of these bits in its visibility_flags.
        distortion: of the colors and labels, see lenses; None: a pinhole.
        lens: a wide-angle Lens, see lenses; horizontal_fov has no effect then.
        samples: a pixel, where the renderer smooths edges; another number than it has means one.
        intrinsics: replace horizontal_fov in the image; None: square pixels about its middle.
    """

    name: str
    key: int | None
    link_index: int
    pose: PoseTuple
    width: int
    height: int
    horizontal_fov: float
    near: float
    far: float
    noise_stddev: float = 0.0
    seed: int = 0
    noise_mean: float = 0.0
    depth: bool = False
    distortion: Distortion | None = None
    lens: Lens | None = None
    labels: bool = False
    visibility: int = VISIBLE
    samples: int = 4
    intrinsics: Intrinsics | None = None

    @classmethod
    def from_spec(cls, spec: Any, key: int, link_index: int, seed: int = 0) -> CameraRequest:
        """Request for a CameraSpec whose link is row `link_index` of body `key`."""
        same = (field.name for field in fields(cls) if hasattr(spec, field.name))
        given = {name: getattr(spec, name) for name in same}
        return cls(**given, key=key, link_index=link_index, seed=seed)


@dataclass(frozen=True)
class Frame:
    """A finished image.

    Attributes:
        time: of the snapshot [s].
        step: of the snapshot.
        rgb: (H, W, 3) uint8, top row first.
        depth: (H, W) float32 [m] along the optical axis, far where nothing is; None: not
            requested.
        labels: (H, W) int32, BodySource.key of what each pixel shows, 0: nothing; None: not
            requested.
        epoch: RenderClient.epoch at the request.
    """

    camera: str
    time: float
    step: int
    rgb: Array
    depth: Array | None = None
    labels: Array | None = None
    epoch: int = 0


@dataclass(frozen=True)
class RendererInfo:
    """The renderer in use.

    Attributes:
        kind: 'gl' or 'tiny'.
        reason: why it is not OpenGL; '' when it is, or when OpenGL was not requested.
        details: what renders, e.g. the driver's name, with shadows and antialiasing.
    """

    kind: str
    reason: str = ""
    details: str = ""


@dataclass(frozen=True)
class Quality:
    """Costly features of the OpenGL renderer: 'auto' (with a GPU), 'true', 'false'."""

    shadows: str = "auto"
    antialias: str = "auto"

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value not in SWITCHES:
                raise ValueError(f"{name} is '{value}', must be one of {', '.join(SWITCHES)}")


DEFAULT = Quality()
