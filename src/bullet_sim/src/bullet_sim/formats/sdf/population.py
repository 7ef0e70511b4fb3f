"""<population> of SDF: many models at places that a distribution computes.

As Gazebo's physics/Population.cc does it, but with numbers of its own that are the same at each
start: Gazebo's random numbers depend on its seed.
"""

from __future__ import annotations

import math
import zlib
from typing import List, Tuple

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.pose import Array
from bullet_sim.xml_reader import Node, child_floats, child_text, sdf_pose

Places = List[Tuple[float, float, float]]
LINES = {"linear-x": 0, "linear-y": 1, "linear-z": 2}
DISTRIBUTIONS = ("random", "uniform", "grid", *LINES)
MAX_MODELS = 10_000
_SPACING = 0.1  # [m] of the samples of an even distribution in a box
_SAMPLES = 10_000  # in a cylinder; in a box, with a wider spacing, about as many at most
_ROUNDS = 100  # of the clustering, at most


def places(population: Node, label: str) -> Places:
    """World positions [m] of the models of a <population>, in their order.

    Args:
        label: of the population, for messages.

    Raises:
        ModelError: what it lacks, or a value that makes no sense; Gazebo leaves it out then.
    """
    pose_element = population.find("pose")
    if pose_element is None:
        raise ModelError(f"{label} has no <pose>")
    pose = sdf_pose(population, label)
    kind = child_text(population, "distribution/type") or "random"
    if kind not in DISTRIBUTIONS:
        raise ModelError(f"{label} has distribution '{kind}', must be {', '.join(DISTRIBUTIONS)}")
    rng = np.random.default_rng(zlib.crc32((population.get("name") or "").encode()))
    if kind == "grid":
        corner, offsets = _grid(population, label)
    else:
        count = _count(population, "model_count", label, 1)
        corner, offsets = _in_region(population, kind, count, label, rng)
    start = np.asarray(pose.position) - corner  # as there: not along the axes of the pose
    return [tuple(place) for place in (start + offsets @ pose.matrix.T).tolist()]


def _grid(population: Node, label: str) -> tuple[Array, Array]:
    """The half of the grid's size, and the offsets from its first place, row by row along x."""
    rows, cols = (
        _count(population, f"distribution/{name}", label, None) for name in ("rows", "cols")
    )
    if population.find("distribution/step") is None:
        raise ModelError(f"{label} has no <step>")
    step = child_floats(population, "distribution/step", 3, label, (0.0, 0.0, 0.0))
    if rows * cols > MAX_MODELS:
        raise ModelError(f"{label} has {rows} x {cols} models, the most are {MAX_MODELS}")
    offsets = [(col * step[0], row * step[1], 0.0) for row in range(rows) for col in range(cols)]
    half = (step[0] * (cols - 1) / 2.0, step[1] * (rows - 1) / 2.0, 0.0)
    return np.array(half), np.array(offsets)


def _in_region(
    population: Node, kind: str, count: int, label: str, rng: np.random.Generator
) -> tuple[Array, Array]:
    """The corner of the region from its pose, and the offsets from there."""
    if population.find("box") is not None:
        size = np.array(child_floats(population, "box/size", 3, label, (0.0, 0.0, 0.0)))
        if not (size > 0.0).all():
            raise ModelError(f"{label} <box> has size {tuple(size)}, must be above 0")
        if kind == "random":
            return size / 2.0, rng.uniform(0.0, size, (count, 3))
        if kind == "uniform":
            return size / 2.0, _even(_in_box(size, rng), count, label, rng)
        offsets = np.tile(size / 2.0, (count, 1))
        axis = LINES[kind]
        offsets[:, axis] = size[axis] * np.arange(count) / count
        return size / 2.0, offsets
    if population.find("cylinder") is None:
        raise ModelError(f"{label} has no <box> and no <cylinder>")
    radius, length = (_above_zero(population, f"cylinder/{tag}", label) for tag in _CYLINDER)
    if kind == "random":
        return np.zeros(3), _in_cylinder(radius, length, count, rng)
    if kind == "uniform":
        samples = _in_cylinder(radius, length, _SAMPLES, rng)
        return np.zeros(3), _even(samples, count, label, rng)
    raise ModelError(f"{label} has distribution '{kind}' in a <cylinder>, must be in a <box>")


_CYLINDER = ("radius", "length")


def _above_zero(population: Node, path: str, label: str) -> float:
    (value,) = child_floats(population, path, 1, label, (0.0,))
    if value <= 0.0:
        raise ModelError(f"{label} <{path}> is {value:g}, must be above 0")
    return value


def _count(population: Node, path: str, label: str, default: int | None) -> int:
    """A number of models; None: the tag has to be there."""
    text = child_text(population, path)
    if not text:
        if default is None:
            raise ModelError(f"{label} has no <{path.rpartition('/')[2]}>")
        return default
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 1 <= value <= MAX_MODELS:
        raise ModelError(f"{label} <{path}> is {text}, must be a number from 1 to {MAX_MODELS}")
    return int(value)


def _in_box(size: Array, rng: np.random.Generator) -> Array:
    """Samples in a box, on a square grid at random heights."""
    spacing = max(_SPACING, math.sqrt(size[0] * size[1] / _SAMPLES))
    x, y = (np.arange(0.0, side, spacing) for side in size[:2])
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return np.column_stack([grid, rng.uniform(0.0, size[2], len(grid))])


def _in_cylinder(radius: float, length: float, count: int, rng: np.random.Generator) -> Array:
    """Random places in a cylinder above its base; denser about its axis, as in Gazebo."""
    angle, distance = rng.uniform(0.0, 2.0 * math.pi, count), rng.uniform(0.0, radius, count)
    height = rng.uniform(0.0, length, count)
    return np.column_stack([distance * np.cos(angle), distance * np.sin(angle), height])


def _even(samples: Array, count: int, label: str, rng: np.random.Generator) -> Array:
    """Centers of clusters of samples (Lloyd's algorithm, as Gazebo's Kmeans)."""
    if count > len(samples):
        raise ModelError(f"{label} has {count} models, its region holds at most {len(samples)}")
    centers = samples[rng.choice(len(samples), count, replace=False)]
    nearest = np.full(len(samples), -1)
    for _ in range(_ROUNDS):
        squares = (samples**2).sum(1)[:, None] - 2.0 * samples @ centers.T + (centers**2).sum(1)
        closest = squares.argmin(1)
        changed = int((closest != nearest).sum())
        nearest = closest
        for number in range(count):
            own = samples[nearest == number]
            if len(own):
                centers[number] = own.mean(0)
        if changed * 1000 <= len(samples):
            break
    return centers
