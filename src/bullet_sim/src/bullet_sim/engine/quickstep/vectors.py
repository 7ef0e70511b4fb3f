"""Vectors, rotations, inertias, polygons: arrays of numbers, results into the last argument."""

import math

from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.pose import Array


@compiled
def copy(a: Array, out: Array) -> None:
    for k in range(len(a)):
        out[k] = a[k]


@compiled
def cross(a: Array, b: Array, out: Array) -> None:
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    out[0], out[1], out[2] = x, y, z


@compiled
def rotate(m: Array, v: Array, out: Array) -> None:
    """out = m v, of a matrix as nine numbers."""
    x = m[0] * v[0] + m[1] * v[1] + m[2] * v[2]
    y = m[3] * v[0] + m[4] * v[1] + m[5] * v[2]
    z = m[6] * v[0] + m[7] * v[1] + m[8] * v[2]
    out[0], out[1], out[2] = x, y, z


@compiled
def rotate_back(m: Array, v: Array, out: Array) -> None:
    """out = m^T v, of a matrix as nine numbers."""
    x = m[0] * v[0] + m[3] * v[1] + m[6] * v[2]
    y = m[1] * v[0] + m[4] * v[1] + m[7] * v[2]
    z = m[2] * v[0] + m[5] * v[1] + m[8] * v[2]
    out[0], out[1], out[2] = x, y, z


@compiled
def matrix(q: Array, out: Array) -> None:
    """Rotation matrix (nine numbers) of a quaternion (x, y, z, w)."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    out[0], out[1], out[2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[3], out[4], out[5] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[6], out[7], out[8] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@compiled
def multiply(a: Array, b: Array, out: Array) -> None:
    """Quaternion product a b."""
    x = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    y = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    z = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    w = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    out[0], out[1], out[2], out[3] = x, y, z, w


@compiled
def similar(r: Array, m: Array, out: Array) -> None:
    """out = r m r^T, of matrices as nine numbers."""
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                for n in range(3):
                    total += r[3 * i + k] * m[3 * k + n] * r[3 * j + n]
            out[3 * i + j] = total


@compiled
def plane_space(n: Array, p: Array, q: Array) -> None:
    """Two unit vectors across n and across each other, as ODE chooses them."""
    if abs(n[2]) > math.sqrt(0.5):
        a = n[1] * n[1] + n[2] * n[2]
        k = 1.0 / math.sqrt(a)
        p[0], p[1], p[2] = 0.0, -n[2] * k, n[1] * k
        q[0], q[1], q[2] = a * k, -n[0] * p[2], n[0] * p[1]
    else:
        a = n[0] * n[0] + n[1] * n[1]
        k = 1.0 / math.sqrt(a)
        p[0], p[1], p[2] = -n[1] * k, n[0] * k, 0.0
        q[0], q[1], q[2] = -n[2] * p[1], n[2] * p[0], a * k


@compiled
def invert(m: Array, out: Array) -> None:
    """Inverse of a symmetric matrix (nine numbers)."""
    a, b, c, d, e, f = m[0], m[1], m[2], m[4], m[5], m[8]
    det = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    out[0], out[1], out[2] = (d * f - e * e) / det, (c * e - b * f) / det, (b * e - c * d) / det
    out[3], out[4], out[5] = out[1], (a * f - c * c) / det, (b * c - a * e) / det
    out[6], out[7], out[8] = out[2], out[5], (a * d - b * b) / det


@compiled
def closest(point: Array, corners: Array, out: Array) -> None:
    """The point of a triangle of nine numbers that is closest to a point.

    C. Ericson, "Real-Time Collision Detection" (2004), 5.1.5.
    """
    ab, ac, arm = temporary(3), temporary(3), temporary(3)
    d = temporary(6)  # of both edges with the arm from each corner
    d[:] = 0.0
    for k in range(3):
        ab[k] = corners[3 + k] - corners[k]
        ac[k] = corners[6 + k] - corners[k]
    for i in range(3):
        for k in range(3):
            arm[k] = point[k] - corners[3 * i + k]
            d[2 * i] += ab[k] * arm[k]
            d[2 * i + 1] += ac[k] * arm[k]
    va, vb = d[2] * d[5] - d[4] * d[3], d[4] * d[1] - d[0] * d[5]
    vc = d[0] * d[3] - d[2] * d[1]
    v = w = 0.0
    if d[0] <= 0.0 and d[1] <= 0.0:
        v = w = 0.0
    elif d[2] >= 0.0 and d[3] <= d[2]:
        v = 1.0
    elif vc <= 0.0 and d[0] >= 0.0 and d[2] <= 0.0:
        v = d[0] / (d[0] - d[2])
    elif d[5] >= 0.0 and d[4] <= d[5]:
        w = 1.0
    elif vb <= 0.0 and d[1] >= 0.0 and d[5] <= 0.0:
        w = d[1] / (d[1] - d[5])
    elif va <= 0.0 and d[3] >= d[2] and d[4] >= d[5]:
        w = (d[3] - d[2]) / ((d[3] - d[2]) + (d[4] - d[5]))
        v = 1.0 - w
    else:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    for k in range(3):
        out[k] = corners[k] + v * ab[k] + w * ac[k]


@compiled
def clip_line(x: float, y: float, z: float, distance: float, ends: Array) -> bool:
    """Shorten a line (2, 3) to where (x, y, z) p + distance >= 0; whether there is some."""
    a = x * ends[0, 0] + y * ends[0, 1] + z * ends[0, 2] + distance
    b = x * ends[1, 0] + y * ends[1, 1] + z * ends[1, 2] + distance
    if a < 0.0 and b < 0.0:
        return False
    if a < 0.0 < b or b < 0.0 < a:
        cut = 0 if a < 0.0 else 1
        for k in range(3):
            ends[cut, k] = ends[0, k] - (ends[0, k] - ends[1, k]) * (a / (a - b))
    return True


@compiled
def clip_polygon(
    x: float, y: float, z: float, distance: float, points: Array, count: int, out: Array
) -> int:
    """Corners of the part of a polygon where (x, y, z) p + distance >= 0; their number."""
    n, before = 0, count - 1
    for i in range(count):
        p, q = points[before], points[i]
        a = x * p[0] + y * p[1] + z * p[2] + distance
        b = x * q[0] + y * q[1] + z * q[2] + distance
        if a >= 0.0:
            copy(p, out[n])
            n += 1
        if a < 0.0 < b or b < 0.0 < a:
            for k in range(3):
                out[n, k] = p[k] - (p[k] - q[k]) * (a / (a - b))
            n += 1
        before = i
    return n


@compiled
def dot(a: Array, b: Array) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def normalize(a: Array) -> None:
    length = math.sqrt(dot(a, a))
    for k in range(3):
        a[k] /= length


@compiled
def overlap(low: Array, high: Array, box: Array) -> bool:
    """Whether a box overlaps one of six numbers: its lower and its upper corner; what is not a
    number overlaps nothing."""
    for k in range(3):
        if not (low[k] <= box[3 + k] and high[k] >= box[k]):
            return False
    return True
