"""libigl's SLIM on one square chart a piece: run_slim.py MESH.obj OUT --texels 65,129 --repeat 3

A mean-value map of the disk onto the square starts it, then 30 iterations on symmetric Dirichlet with the boundary held
softly at 1e5, as its authors do. `cpu_s` is these two alone, process time, once a repetition; reading, cutting,
sampling and writing are not in it. Writes OUT/slim_N.npy and prints JSON.
"""
import argparse
import json
import os
import time

import igl
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

import image
import surface

ITERATIONS, SOFT = 30, 1e5


def mean_value(V, F, loop, place):
    """Floater's mean-value map with the boundary held."""
    n, rows, columns, weights = len(V), [], [], []
    for k in range(3):
        at, to, back = F[:, k], F[:, (k + 1) % 3], F[:, (k + 2) % 3]
        u, v = V[to] - V[at], V[back] - V[at]
        lu, lv = np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1)
        half = np.linalg.norm(np.cross(u, v), axis=1) / np.maximum(lu * lv + (u * v).sum(axis=1), 1e-12 * lu * lv)
        rows += [at, at]
        columns += [to, back]
        weights += [half / np.maximum(lu, 1e-30), half / np.maximum(lv, 1e-30)]
    w = sp.coo_matrix((np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), shape=(n, n)).tocsr()
    laplace = sp.diags(np.asarray(w.sum(axis=1)).ravel()) - w
    inner = np.setdiff1d(np.arange(n), loop)
    UV = np.zeros((n, 2))
    UV[loop] = place
    if len(inner):
        UV[inner] = splu(laplace[inner][:, inner].tocsc()).solve(-(laplace[inner][:, loop] @ place))
    return UV


def slim(V, F, loop, place):
    order = np.asfortranarray
    side = np.sqrt(surface.area(V, F).sum())
    start = mean_value(V, F, loop, place) * side
    data = igl.slim_precompute(
        order(V), order(F.astype(np.int32)), order(start), igl.SYMMETRIC_DIRICHLET,
        loop.astype(np.int32), order(place * side), SOFT,
    )
    return np.asarray(igl.slim_solve(data, ITERATIONS))[:, :2] / side


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("out")
    parser.add_argument("--texels", type=lambda s: [int(x) for x in s.split(",")], required=True)
    parser.add_argument("--repeat", type=int, default=1)
    args = parser.parse_args()
    start = time.process_time()
    disks = [surface.disk(*piece) for piece in surface.pieces(*surface.read_obj(args.mesh))]
    borders = [surface.on_square(*d) for d in disks]
    cut = time.process_time() - start
    cpu = []
    for _ in range(args.repeat):
        start = time.process_time()
        maps = [slim(V, F, *border) for (V, F), border in zip(disks, borders)]
        cpu.append(time.process_time() - start)
    areas = np.array([surface.area(V, F).sum() for V, F in disks])
    flips, stretch = zip(*(image.distortion(V, F, UV, F) for (V, F), UV in zip(disks, maps)))
    out = dict(cut_cpu_s=cut, peak_bytes=image.peak_bytes(), flips=sum(flips), images=[])
    out["l2_stretch"] = float(np.sqrt((areas * np.square(stretch)).sum() / areas.sum()))
    for texels in args.texels:
        sides = [max(9, round(texels * float(np.sqrt(share)))) for share in areas / areas.sum()]
        images = [
            image.at(V, F, UV, F, image.lattice(n, n))[0].reshape(n, n, 3) for (V, F), UV, n in zip(disks, maps, sides)
        ]
        path = os.path.join(args.out, f"slim_{texels}.npy")
        np.save(path, image.canvas(images))
        sizes = " ".join(f"{n}x{n}" for n in sides)
        out["images"].append(dict(texels=texels, path=path, sizes=sizes, cpu_s=cpu))
    print(json.dumps(out))


if __name__ == "__main__":
    main()
