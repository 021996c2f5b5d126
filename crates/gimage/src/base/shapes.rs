//! Surfaces for tests: every topology the pipeline has to deal with.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use crate::base::mesh::Mesh;
use crate::base::surface::Surface;
use crate::stage::border::{Border, Placed};
use crate::stage::cut::disk::Disk;
use crate::stage::layout::Layout;
use crate::stage::repair::{RepairOptions, repair};

/// A surface of its own source.
pub(crate) fn surface(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Surface {
    Surface {
        positions,
        source_triangle: (0..triangles.len() as u32).collect(),
        first_corner: vec![0; triangles.len()],
        triangles,
    }
}

/// The public sample garments: of `$GIMAGE_SHARED`, or of `shared` beside the repository. `None`, with a remark, without.
pub(crate) fn shared_garments() -> Option<std::path::PathBuf> {
    let beside = || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let shared = std::env::var_os("GIMAGE_SHARED").map_or_else(beside, std::path::PathBuf::from).join("garments");
    if !shared.is_dir() {
        eprintln!("skipped: no shared garments (set GIMAGE_SHARED to the folder that holds garments/)");
        return None;
    }
    Some(shared)
}

/// How two opposite sides of a sheet are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Join {
    Open,
    Same,
    Mirrored,
}

/// A sheet of `w` x `h` cells at `f(u, v)`, its sides u = 0, 1 and v = 0, 1 joined as told (at most one of them mirrored).
pub(crate) fn sheet(w: u32, h: u32, ju: Join, jv: Join, f: impl Fn(f64, f64) -> [f64; 3]) -> Surface {
    let columns = if ju == Join::Open { w + 1 } else { w };
    let rows = if jv == Join::Open { h + 1 } else { h };
    let at = |i: u32, j: u32| {
        let (mut x, mut y) = (i, j);
        if ju != Join::Open && x == w {
            x = 0;
            if ju == Join::Mirrored {
                y = h - y;
            }
        }
        if jv != Join::Open && y == h {
            y = 0;
        }
        y * columns + x
    };
    let positions = (0..rows * columns)
        .map(|k| f(f64::from(k % columns) / f64::from(w), f64::from(k / columns) / f64::from(h)))
        .collect();
    let mut triangles = Vec::new();
    for j in 0..h {
        for i in 0..w {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    surface(positions, triangles)
}

/// A flat rectangle `x` by `y` metres.
pub(crate) fn rectangle(w: u32, h: u32, x: f64, y: f64) -> Surface {
    sheet(w, h, Join::Open, Join::Open, |u, v| [x * u, y * v, 0.0])
}

/// An open tube of unit circumference and length `length`.
pub(crate) fn tube(w: u32, h: u32, length: f64) -> Surface {
    let r = 1.0 / TAU;
    sheet(w, h, Join::Same, Join::Open, |u, v| [r * (TAU * u).cos(), length * v, -r * (TAU * u).sin()])
}

/// A torus.
pub(crate) fn torus(w: u32, h: u32) -> Surface {
    sheet(w, h, Join::Same, Join::Same, |u, v| {
        let r = 1.0 + 0.4 * (TAU * v).cos();
        [r * (TAU * u).cos(), 0.4 * (TAU * v).sin(), r * (TAU * u).sin()]
    })
}

/// A Moebius strip.
pub(crate) fn moebius(w: u32, h: u32) -> Surface {
    sheet(w, h, Join::Mirrored, Join::Open, |u, v| {
        let (a, s) = (TAU * u, 0.6 * (v - 0.5));
        let r = 1.0 + s * (0.5 * a).cos();
        [r * a.cos(), s * (0.5 * a).sin(), r * a.sin()]
    })
}

/// A Klein bottle, as the figure-eight immersion.
pub(crate) fn klein(w: u32, h: u32) -> Surface {
    sheet(w, h, Join::Mirrored, Join::Same, |u, v| {
        let (a, b) = (TAU * u, TAU * v);
        let (x, y) = (b.sin(), (2.0 * b).sin());
        let r = 2.0 + (0.5 * a).cos() * x - (0.5 * a).sin() * y;
        [r * a.cos(), (0.5 * a).sin() * x + (0.5 * a).cos() * y, r * a.sin()]
    })
}

/// A ball of latitudes and longitudes.
pub(crate) fn sphere(w: u32, h: u32) -> Surface {
    let mut positions = vec![[0.0, 1.0, 0.0]];
    for j in 1..h {
        for i in 0..w {
            let (a, b) = (TAU * f64::from(i) / f64::from(w), TAU * 0.5 * f64::from(j) / f64::from(h));
            positions.push([b.sin() * a.cos(), b.cos(), -b.sin() * a.sin()]);
        }
    }
    let last = positions.len() as u32;
    positions.push([0.0, -1.0, 0.0]);
    let at = |i: u32, j: u32| 1 + (j - 1) * w + i % w;
    let mut triangles = Vec::new();
    for i in 0..w {
        triangles.push([0, at(i, 1), at(i + 1, 1)]);
        for j in 1..h - 1 {
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([at(i, h - 1), last, at(i + 1, h - 1)]);
    }
    surface(positions, triangles)
}

/// The projective plane: six vertices, each triangle quartered `rounds` times.
pub(crate) fn projective_plane(rounds: usize) -> Surface {
    let mut positions =
        vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.1], [0.3, 1.0, 0.0], [-0.8, 0.6, 0.2], [-0.7, -0.7, -0.1], [0.4, -0.9, 0.3]];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 1, 2],
        [0, 2, 3],
        [0, 3, 4],
        [0, 4, 5],
        [0, 1, 5],
        [1, 2, 4],
        [2, 3, 5],
        [3, 4, 1],
        [4, 5, 2],
        [5, 1, 3],
    ];
    for _ in 0..rounds {
        let mut middle: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut next = Vec::new();
        for t in triangles {
            let m = [0, 1, 2].map(|k| {
                let (a, b) = (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]));
                *middle.entry([a, b]).or_insert_with(|| {
                    positions.push(crate::base::vec3::lerp(positions[a as usize], positions[b as usize], 0.5));
                    positions.len() as u32 - 1
                })
            });
            next.extend([[t[0], m[0], m[2]], [m[0], t[1], m[1]], [m[2], m[1], t[2]], m]);
        }
        triangles = next;
    }
    surface(positions, triangles)
}

/// Without the triangles that `drop` names: repaired, and of what is left the part that holds the most triangles.
pub(crate) fn without(s: &Surface, drop: impl Fn(usize) -> bool) -> Surface {
    let kept = (0..s.triangles.len()).filter(|&t| !drop(t)).map(|t| s.triangles[t]).collect();
    largest(s.positions.clone(), kept)
}

/// A sheet with square holes, `n` a side.
pub(crate) fn holed(n: u32) -> Surface {
    let s = rectangle(4 * n + 1, 4 * n + 1, 1.0, 1.0);
    without(&s, |t| {
        let (i, j) = (t as u32 / 2 % (4 * n + 1), t as u32 / 2 / (4 * n + 1));
        (i % 4) / 2 == 1 && (j % 4) / 2 == 1 && i < 4 * n && j < 4 * n
    })
}

/// The surface of a plate with `genus` holes.
pub(crate) fn plate(genus: i32) -> Surface {
    let filled = (0..2 * genus + 1)
        .flat_map(|x| (0..3).map(move |y| [x, y, 0]))
        .filter(|&[x, y, _]| !(x % 2 == 1 && y == 1))
        .flat_map(|[x, y, z]| (0..8).map(move |k| [2 * x + (k & 1), 2 * y + (k >> 1 & 1), 2 * z + (k >> 2)]))
        .collect();
    voxels(&filled)
}

/// A seeded sequence of numbers below `n` (SplitMix64).
pub(crate) fn random(seed: u64) -> impl FnMut(usize) -> usize {
    let mut state = seed;
    move |n| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}

/// The surface of a random blob of `cells` voxels, `holes` of its triangles removed.
pub(crate) fn blob(seed: u64, cells: usize, holes: usize) -> Surface {
    let mut draw = random(seed);
    let (mut filled, mut list) = (BTreeSet::from([[0, 0, 0]]), vec![[0i32, 0, 0]]);
    while filled.len() < cells {
        let mut c = list[draw(list.len())];
        c[draw(3)] += if draw(2) == 0 { 1 } else { -1 };
        if filled.insert(c) {
            list.push(c);
        }
    }
    let s = voxels(&filled);
    let mut gone: BTreeSet<usize> = (0..holes).map(|_| draw(s.triangles.len())).collect();
    if gone.len() == s.triangles.len() {
        gone.pop_first();
    }
    without(&s, |t| gone.contains(&t))
}

fn voxels(filled: &BTreeSet<[i32; 3]>) -> Surface {
    let (mut index, mut positions, mut triangles) = (BTreeMap::new(), Vec::new(), Vec::new());
    for &c in filled {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beside = c;
                beside[axis] += 2 * side - 1;
                if filled.contains(&beside) {
                    continue;
                }
                let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[p, q]| {
                    let mut v = c;
                    v[axis] += side;
                    v[(axis + 1) % 3] += p;
                    v[(axis + 2) % 3] += q;
                    *index.entry(v).or_insert_with(|| {
                        positions.push(v.map(f64::from));
                        positions.len() as u32 - 1
                    })
                });
                if side == 0 {
                    quad.reverse();
                }
                let [a, b, c, d] = quad;
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    largest(positions, triangles)
}

fn largest(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Surface {
    let mesh = Mesh { triangle_part: vec![0; triangles.len()], positions, triangles, ..Mesh::default() };
    let mesh = repair(mesh, &RepairOptions::default()).expect("default options are sound").mesh;
    let mut sets = gimage_bundle::DisjointSets::new(mesh.positions.len());
    mesh.triangles.iter().for_each(|t| {
        sets.union(t[0], t[1]);
        sets.union(t[0], t[2]);
    });
    let set = sets.into_representatives();
    let mut many = BTreeMap::new();
    mesh.triangles.iter().for_each(|t| *many.entry(set[t[0] as usize]).or_insert(0usize) += 1);
    let most = many.iter().max_by_key(|x| (*x.1, std::cmp::Reverse(*x.0))).map(|x| *x.0);
    let (mut index, mut positions) = (BTreeMap::new(), Vec::new());
    let triangles = mesh
        .triangles
        .iter()
        .filter(|t| Some(set[t[0] as usize]) == most)
        .map(|t| {
            t.map(|v| {
                *index.entry(v).or_insert_with(|| {
                    positions.push(mesh.positions[v as usize]);
                    positions.len() as u32 - 1
                })
            })
        })
        .collect();
    surface(positions, triangles)
}

/// One of each kind, by name.
pub(crate) fn all() -> Vec<(&'static str, Surface)> {
    vec![
        ("rectangle", rectangle(8, 6, 1.6, 1.2)),
        ("triangle", surface(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])),
        ("holed", holed(3)),
        ("tube", tube(12, 8, 0.7)),
        ("sphere", sphere(12, 8)),
        (
            "tetrahedron",
            surface(
                vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            ),
        ),
        ("torus", torus(14, 8)),
        ("double torus", plate(2)),
        ("genus 4", plate(4)),
        ("torus with holes", without(&torus(14, 8), |t| t == 3 || t == 100 || t == 160)),
        ("moebius", moebius(16, 4)),
        ("klein", klein(16, 8)),
        ("projective plane", projective_plane(2)),
        ("projective plane with holes", without(&projective_plane(2), |t| t == 5 || t == 77)),
        ("blob", blob(3, 60, 0)),
        ("blob with holes", blob(4, 60, 12)),
    ]
}

/// Cut along short edges through `terminals` and opened.
pub(crate) fn opened(s: &Surface, terminals: &[u32]) -> crate::stage::cut::disk::Disk {
    let cutter = crate::stage::cut::Cutter::new(s).expect("a manifold");
    let cut = cutter.cut(&cutter.graph.length, terminals);
    crate::stage::cut::disk::open(&cutter, &cut).expect("a disk")
}

/// Which vertices of a surface lie on its boundary.
pub(crate) fn rim(s: &Surface) -> Vec<bool> {
    let cutter = crate::stage::cut::Cutter::new(s).expect("a manifold");
    let mut rim = vec![false; s.positions.len()];
    cutter.loops().iter().flatten().for_each(|&v| rim[v as usize] = true);
    rim
}

/// A map of an opened surface, resampled: everything the later stages take.
pub(crate) struct Mapped {
    pub disk: crate::stage::cut::disk::Disk,
    pub border: crate::stage::border::Border,
    pub uv: Vec<[f64; 2]>,
    pub texels: Vec<crate::stage::border::BorderTexel>,
    pub samples: Vec<crate::stage::sample::resample::Sample>,
    pub w: u32,
    pub h: u32,
}

/// A flat comb: `teeth` strips of `length` cells by two hang from a bar, two cells apart.
pub(crate) fn comb(teeth: u32, length: u32) -> Surface {
    let (w, h) = (4 * teeth - 2, length + 2);
    let s = rectangle(w, h, f64::from(w), f64::from(h));
    without(&s, |t| {
        let (i, j) = (t as u32 / 2 % w, t as u32 / 2 / w);
        j < length && i % 4 >= 2
    })
}

/// A flat strip of two rows of cells that winds inwards `turns` times.
pub(crate) fn spiral(turns: f64, cells: u32) -> Surface {
    sheet(cells, 2, Join::Open, Join::Open, |u, v| {
        let (a, r) = (TAU * turns * u, 1.0 + turns * u + 0.5 * v);
        [r * a.cos(), r * a.sin(), 0.0]
    })
}

/// `n` triangles around one vertex, every second corner `far` times as far away as the others.
pub(crate) fn fan(n: u32, far: f64) -> Surface {
    let mut positions = vec![[0.0, 0.0, 0.3]];
    positions.extend((0..n).map(|k| {
        let (a, r) = (TAU * f64::from(k) / f64::from(n), if k % 2 == 0 { 1.0 } else { far });
        [r * a.cos(), r * a.sin(), 0.0]
    }));
    surface(positions, (0..n).map(|k| [0, 1 + k, 1 + (k + 1) % n]).collect())
}

/// A sheet of cells whose columns are `thin` wide, one in three of them of the width 1.
pub(crate) fn slivers(w: u32, h: u32, thin: f64) -> Surface {
    let at = |i: u32| f64::from(i.div_ceil(3)) + thin * f64::from(i - i.div_ceil(3));
    sheet(w, h, Join::Open, Join::Open, |u, v| [at((u * f64::from(w)).round() as u32), v * f64::from(w), 0.1 * u])
}

/// A sheet with `n` x `n` thin spikes, each `height` cells tall.
pub(crate) fn hedgehog(n: u32, height: f64) -> Surface {
    let cells = 6 * n;
    sheet(cells, cells, Join::Open, Join::Open, |u, v| {
        let near = |x: f64| 1.0 - (2.0 * ((x * f64::from(n)).fract() - 0.5)).abs();
        let tip = near(u).min(near(v)).powi(3);
        [f64::from(cells) * u, f64::from(cells) * v, height * tip]
    })
}

/// A tube that is closed at its far end and `length` times as long as it is around, its rows `rows`.
pub(crate) fn sock(around: u32, rows: u32, length: f64) -> Surface {
    let s = tube(around, rows, length);
    let (mut positions, mut triangles) = (s.positions, s.triangles);
    let tip = positions.len() as u32;
    positions.push([0.0, length * 1.01, 0.0]);
    let first = rows * around;
    triangles.extend((0..around).map(|k| [first + k, first + (k + 1) % around, tip]));
    surface(positions, triangles)
}

/// Disks that are hard to map: arms, fjords, slivers and needles, by name.
pub(crate) fn hard() -> Vec<(&'static str, Surface)> {
    vec![
        ("lace", holed(6)),
        ("comb", comb(12, 40)),
        ("spiral", spiral(6.0, 400)),
        ("ribbon", rectangle(2000, 2, 10_000.0, 1.0)),
        ("fan", fan(2000, 1.001)),
        ("star", fan(400, 1e4)),
        ("slivers", slivers(30, 30, 1e-8)),
        ("needles", slivers(12, 200, 1e-3)),
        ("hedgehog", hedgehog(5, 40.0)),
        ("sock", sock(12, 200, 30.0)),
        ("long tube", tube(6, 600, 100.0)),
        ("plate", plate(8)),
        ("tree", blob(11, 400, 60)),
    ]
}

/// A surface opened and laid on `w` x `h` cells, or as many as it needs, its boundary starting at the corner (0, 0): its
/// border, where that went, and the cells.
fn placed(s: &Surface, w: u32, h: u32) -> (Border, Placed, u32, u32) {
    let mut disk = opened(s, &[]);
    let rim = rim(s);
    let border = Border::new(&mut disk, |v| rim[v as usize]);
    let least = border.least_steps().div_ceil(4);
    let (w, h) = (w.max(least), h.max(least));
    let count = border.share(2 * (w + h)).expect("room enough");
    let layout = Layout { w, h, shift: 0.0, count, score: 0.0 };
    let placed = border.place(&disk, s, &|v| rim[v as usize], &layout).expect("placed");
    (border, placed, w, h)
}

/// A surface opened and laid on `w` x `h` cells, or as many as it needs: a disk, and the places of its boundary.
pub(crate) fn laid(s: &Surface, w: u32, h: u32) -> (Disk, Vec<[f64; 2]>) {
    let (_, placed, ..) = placed(s, w, h);
    (placed.disk, placed.uv)
}

/// Lays a surface on `w` x `h` cells, or as many as it needs, and maps it.
pub(crate) fn mapped(s: &Surface, w: u32, h: u32) -> Mapped {
    use crate::stage::parameterize::{NewtonOptions, parameterize};
    let (border, placed, w, h) = placed(s, w, h);
    let (disk, mut uv, texels) = (placed.disk, placed.uv, placed.texels);
    let fixed = disk.boundary_mask();
    parameterize(disk.shape(&fixed), &mut uv, 3, &NewtonOptions::default(), usize::MAX / 2).expect("a map");
    let samples = crate::stage::sample::resample::resample(&disk, &uv, &texels, w, h).expect("all texels inside");
    Mapped { disk, border, uv, texels, samples, w, h }
}
