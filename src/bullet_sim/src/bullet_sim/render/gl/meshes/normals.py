"""Normals of meshes whose files give none: flat faces stay flat, round ones look round."""

import math

import numpy as np

CREASE = math.radians(35.0)  # faces that meet at a sharper angle keep an edge between them


def crease_normals(vertices, faces, crease=CREASE):
    """Normal of each corner of each face: the mean over the faces there that bend less.

    Args:
        vertices: (n, 3).
        faces: (m, 3) int, counter-clockwise seen from outside.
        crease: [rad].

    Returns:
        (3 m, 3) float64 of length 1, corner by corner; faces without area have (0, 0, 1).
    """
    corners = vertices[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    units = np.where(lengths > 0.0, areas / np.where(lengths > 0.0, lengths, 1.0), (0.0, 0.0, 1.0))
    _, place = np.unique(vertices[faces.ravel()], axis=0, return_inverse=True)
    order = np.argsort(place, kind="stable")
    counts = np.bincount(place)
    first = np.cumsum(counts) - counts
    partners = counts[place[order]]  # of each corner, with itself
    one = np.repeat(np.arange(len(order)), partners)
    offset = np.arange(len(one)) - np.repeat(np.cumsum(partners) - partners, partners)
    other = first[place[order]][one] + offset
    face_of_one, face_of_other = order[one] // 3, order[other] // 3
    near = np.einsum("ij,ij->i", units[face_of_one], units[face_of_other]) > math.cos(crease)
    sums = np.empty((len(order), 3))
    for axis in range(3):
        sums[:, axis] = np.bincount(
            order[one[near]], areas[face_of_other[near], axis], minlength=len(order)
        )
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    flat = np.repeat(units, 3, axis=0)
    return np.where(lengths > 0.0, sums / np.where(lengths > 0.0, lengths, 1.0), flat)
