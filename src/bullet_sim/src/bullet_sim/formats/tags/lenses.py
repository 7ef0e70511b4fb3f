"""What a <camera> and a <ray> see, brought into the bounds of what can be drawn and cast."""

import math

from bullet_sim.description.lens import FUNCTIONS, TYPES, Lens
from bullet_sim.formats.xml_read import child_flag, child_number, child_text, replace

WIDEST = math.radians(175.0)  # [rad] of a pinhole; at 180 degrees its picture has no end
FULL_TURN = 2.0 * math.pi
FIELD_OF_VIEW = 1.047  # [rad] where none is given
INVISIBLE = 1e-6  # of a coefficient of a lens
CLIP = (0.1, 100.0)  # [m] nearest and furthest that is drawn, where none is given
FURTHEST = 100.0  # [m] that a lidar sees whose file gives nothing usable
ENCODINGS = {
    "R8G8B8": "rgb8",
    "RGB8": "rgb8",
    "RGB_INT8": "rgb8",
    "B8G8R8": "bgr8",
    "BGR8": "bgr8",
    "BGR_INT8": "bgr8",
    "L8": "mono8",
    "MONO8": "mono8",
    "L_INT8": "mono8",
}


def encoding(camera, what, model):
    """Encoding of a camera's messages: rgb8, bgr8 or mono8."""
    form = child_text(camera, "image/format", "R8G8B8")
    found = ENCODINGS.get(form.upper())
    if found is None:
        model.warn(
            f"{what} has image format '{form}', known are {', '.join(ENCODINGS)}; "
            "it becomes R8G8B8",
            "cameras have an image format that is not known here and get R8G8B8",
            f"{what} '{form}'",
        )
    return found or "rgb8"


def field_of_view(camera, what, wide=False):
    """Horizontal angle of a camera [rad], below 180 degrees.

    Args:
        camera: the <camera>.
        what: for the message.
        wide: it has a wide-angle lens, for which a pinhole stands in: too wide is no mistake.
    """
    angle = child_number(camera, "horizontal_fov", what, FIELD_OF_VIEW)
    if 0.0 < angle <= WIDEST:
        return angle
    if wide and angle > 0.0:
        return WIDEST
    used = WIDEST if angle > 0.0 else FIELD_OF_VIEW
    sentence = (
        f"{what} <horizontal_fov> is {angle:g}, a pinhole's is above 0 and at most {WIDEST:.3f}"
    )
    replace(camera.find("horizontal_fov"), f"{what} <horizontal_fov>", f"{angle:g}", sentence, used)
    return used


def wide_lens(camera, what, model):
    """Lens of a wide-angle camera; where it names none, Gazebo's stereographic one."""
    fov = child_number(camera, "horizontal_fov", what, FIELD_OF_VIEW)
    fov = min(fov, FULL_TURN) if fov > 0.0 else FIELD_OF_VIEW
    kind = child_text(camera, "lens/type", "stereographic")
    scaled = child_flag(camera, "lens/scale_to_hfov", what, True)
    cutoff = child_number(camera, "lens/cutoff_angle", what, math.pi)
    if kind == "custom":
        c1, c2, c3, f = (
            child_number(camera, f"lens/custom_function/{name}", what, default)
            for name, default in (("c1", 1.0), ("c2", 1.0), ("c3", 0.0), ("f", 1.0))
        )
        function = child_text(camera, "lens/custom_function/fun", "tan")
    else:
        if kind not in TYPES:
            model.warn(
                f"{what} has a lens of type '{kind}', known are {', '.join(TYPES)}, custom; it "
                "becomes stereographic",
                "lenses have a type that is not known here and become stereographic",
                f"{what} '{kind}'",
            )
        c1, c2, function = TYPES.get(kind, TYPES["stereographic"])
        c3, f = 0.0, 1.0
    lens = Lens(fov, c1, c2, c3, f, function, scaled, cutoff)
    if function in FUNCTIONS and c1 * f > 0.0 and c2 > 0.0 and _fills(lens):
        return lens
    model.warn(
        f"{what} has a lens that shows nothing (c1 {c1:g}, c2 {c2:g}, c3 {c3:g}, f {f:g}, function "
        f"'{function}', {fov:g} rad); it becomes equidistant",
        "lenses show nothing and become equidistant",
        what,
    )
    return Lens(fov, cutoff=cutoff)


def _fills(lens):
    """Whether the angle of a lens has a place on its picture."""
    edge = lens.fov / 2.0 / lens.c2 + lens.c3
    limit = {"tan": math.pi / 2.0 - 1e-3, "sin": math.pi / 2.0 + 1e-9, "id": math.inf}
    return not lens.scaled or 0.0 < edge < limit[lens.function]


def distortion(camera, plugin, what):
    """(k1, k2, p1, p2, k3) of a lens, () of a pinhole.

    Those of the <camera> count, else those of its plugin; values too small to be seen are none.
    """
    names = ("k1", "k2", "p1", "p2", "k3")
    found = [child_number(camera, f"distortion/{name}", what, 0.0) for name in names]
    if camera.find("distortion") is None:
        names = ("K1", "K2", "T1", "T2", "K3")
        found = [child_number(plugin, f"distortion{name}", what, 0.0) for name in names]
    return tuple(found) if max(map(abs, found)) > INVISIBLE else ()


def clip(camera, what):
    """(nearest, furthest) distance that a camera draws [m]."""
    near = child_number(camera, "clip/near", what, CLIP[0])
    far = child_number(camera, "clip/far", what, CLIP[1])
    if 0.0 < near < far:
        return near, far
    used = (near if near > 0.0 else CLIP[0], CLIP[1])
    used = used if used[0] < used[1] else CLIP
    sentence = f"{what} <clip> is {near:g} to {far:g}, must be above 0, the smaller first"
    replace(camera.find("clip"), f"{what} <clip>", f"{near:g} {far:g}", sentence, used)
    return used


def sweep(ray, what):
    """(first, last) angle of a lidar [rad], the smaller first."""
    angles = tuple(
        child_number(ray, f"scan/horizontal/{end}_angle", what, 0.0) for end in ("min", "max")
    )
    if angles[0] <= angles[1]:
        return angles
    used = angles[::-1]
    sentence = f"{what} has angles {angles[0]:g} to {angles[1]:g}, the smaller must come first"
    shown = f"{angles[0]:g} {angles[1]:g}"
    replace(ray.find("scan/horizontal"), f"{what} angles", shown, sentence, used)
    return used


def reach(ray, what):
    """(nearest, furthest) range of a lidar [m]."""
    near = child_number(ray, "range/min", what, 0.0)
    far = child_number(ray, "range/max", what, FURTHEST)
    if 0.0 <= near < far:
        return near, far
    used = (max(0.0, near), far if far > max(0.0, near) else max(0.0, near) + FURTHEST)
    sentence = f"{what} <range> is {near:g} to {far:g}, must be 0 or more, the smaller first"
    replace(ray.find("range"), f"{what} <range>", f"{near:g} {far:g}", sentence, used)
    return used
