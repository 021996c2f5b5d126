"""xatlas, many charts in one atlas: run_xatlas.py MESH.obj OUT --texels 65,129 --repeat 3

Charts keep 3 texels apart. A texel within 0.7 texel of a chart takes the nearest point of that chart, so that charts
reach their own borders and no quad of texels joins two of them. `cpu_s` is charting and packing, once a repetition. xatlas may lay charts down mirrored, which
`mirrored` says: normals and folds of such an image mean nothing.
Writes OUT/xatlas_N.npy with NaN where a texel is unused, and prints JSON.
"""
import argparse
import json
import os
import time

import numpy as np
import xatlas

import image
import surface

PADDING, REACH = 3, 0.7


def atlas_of(V, F, texels):
    """The largest atlas found within the budget, and the CPU seconds that it alone took.

    xatlas takes a density and answers with a size, so a few densities are tried; a user would know theirs.
    """
    density = texels * np.sqrt(0.5 / surface.area(V, F).sum())
    best = None
    for _ in range(10):
        start = time.process_time()
        atlas = xatlas.Atlas()
        atlas.add_mesh(V.astype(np.float32), F.astype(np.uint32))
        pack = xatlas.PackOptions()
        pack.padding, pack.texels_per_unit, pack.bilinear = PADDING, density, True
        atlas.generate(xatlas.ChartOptions(), pack)
        cpu = time.process_time() - start
        share = atlas.width * atlas.height / texels**2
        if atlas.atlas_count == 1 and share <= 1 and (best is None or share > best[0]):
            best = share, atlas, cpu
        if best and (best[0] > 0.93 or share > 1):
            break
        density *= 0.98 / np.sqrt(max(share, 0.1))
    if best is None:
        raise ValueError(f"no atlas within {texels} x {texels} texels")
    return best[1:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("out")
    parser.add_argument("--texels", type=lambda s: [int(x) for x in s.split(",")], required=True)
    parser.add_argument("--repeat", type=int, default=1)
    args = parser.parse_args()
    V, F = surface.read_obj(args.mesh)
    out = dict(mirrored=True, images=[])
    for texels in args.texels:
        cpu = []
        for _ in range(args.repeat):
            atlas, seconds = atlas_of(V, F, texels)
            cpu.append(seconds)
        source, corner, UV = atlas[0]
        corner = corner.astype(np.int64)
        width, height = atlas.width, atlas.height
        # xatlas counts texels from their edges, a lattice from their centres.
        plane = UV.astype(float) * [width, height]
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        points, away = image.at(V, source.astype(np.int64)[corner], plane, corner, np.stack([x.ravel(), y.ravel()], axis=1))
        points[away > REACH] = np.nan
        path = os.path.join(args.out, f"xatlas_{texels}.npy")
        np.save(path, points.reshape(height, width, 3).astype("<f4"))
        out["peak_bytes"] = image.peak_bytes()
        out["images"].append(dict(texels=texels, path=path, sizes=f"{width}x{height}", cpu_s=cpu))
    print(json.dumps(out))


if __name__ == "__main__":
    main()
