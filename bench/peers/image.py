"""Geometry images from charts: sampling, several images on one canvas, the distortion of a map."""
import resource
import sys

import igl
import numpy as np


def peak_bytes():
    """Largest resident memory of this process so far."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def lattice(width, height):
    """The points of a grid over the unit square, corners included, row by row."""
    x, y = np.meshgrid(np.linspace(0, 1, width), np.linspace(0, 1, height))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def at(V, F, UV, FUV, points):
    """Surface points under points of the plane, and how far each lies from the nearest triangle of the map."""
    flat = lambda p: np.column_stack([p, np.zeros(len(p))])
    d2, triangle, nearest = igl.point_mesh_squared_distance(flat(points), flat(UV), np.ascontiguousarray(FUV))
    p, q, r = (UV[FUV[triangle, k]] for k in range(3))
    cross = lambda a, b: a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    whole = cross(q - p, r - p)
    whole = np.where(np.abs(whole) < 1e-300, 1e-300, whole)
    x = nearest[:, :2] - p
    w = np.stack([np.zeros(len(x)), cross(x, r - p) / whole, cross(q - p, x) / whole], axis=1)
    w[:, 0] = 1 - w[:, 1] - w[:, 2]
    w = np.clip(w, 0, 1)
    w /= w.sum(axis=1, keepdims=True)
    return (V[F[triangle]] * w[:, :, None]).sum(axis=1), np.sqrt(np.maximum(d2, 0))


def canvas(images):
    """Images side by side with an empty column between, so that one file holds every piece."""
    height = max(im.shape[0] for im in images)
    columns = []
    for im in images:
        full = np.full((height, im.shape[1], 3), np.nan)
        full[: im.shape[0]] = im
        columns += [full, np.full((height, 1, 3), np.nan)]
    return np.concatenate(columns[:-1], axis=1).astype("<f4")


def distortion(V, F, UV, FUV):
    """Flipped triangles, and Sander's L2 stretch of the map (1 for an isometry up to size)."""
    p, q, r = (UV[FUV[:, k]] for k in range(3))
    plane = (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])
    plane = plane * (1 if plane.sum() >= 0 else -1)
    a, b, c = (V[F[:, k]] for k in range(3))
    surface = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    good = (plane > 1e-14 * np.abs(plane).sum()) & (surface > 1e-14 * surface.sum())
    mix = lambda k: sum(x * w[:, None] for x, w in ((a, (q - r)[:, k]), (b, (r - p)[:, k]), (c, (p - q)[:, k])))
    with np.errstate(all="ignore"):
        squares = ((mix(0) ** 2).sum(axis=1) + (mix(1) ** 2).sum(axis=1)) / plane**2
    scale = np.abs(plane).sum() / surface.sum()
    l2 = np.sqrt((surface * squares)[good].sum() * scale / 2 / surface[good].sum())
    return int((plane < 0).sum()), float(l2)
