//! Converts grids back to one welded triangle mesh.

use gimage_bundle::DisjointSets;

use crate::base::grid::split;
use crate::base::mesh::NONE;
use crate::base::vec3::{add, cross, norm, scale, sub};
use crate::error::{Error, Result};
use std::ops::Range;

/// One piece of a bundle as read.
#[derive(Clone, Copy, Debug)]
pub struct PieceView<'a> {
    /// Its name.
    pub name: &'a str,
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The bundle-wide index of its texel (0, 0).
    pub first_particle: u32,
    /// x, y, z \[m\] and the particle code w of each texel: 0 none, |w| = 1 ordinary, |w| >= 2 a duplicate whose next one
    /// has the bundle-wide index |w| - 2.
    pub position: &'a [[f32; 4]],
    /// Texture coordinates of each texel, glTF convention (v down).
    pub uv: Option<&'a [[f32; 2]]>,
}

/// One piece of a [`Reconstruction`].
#[derive(Clone, Debug, PartialEq)]
pub struct ReconstructedPiece {
    /// Its name.
    pub name: String,
    /// Its triangles in [`Reconstruction::triangles`].
    pub triangles: Range<usize>,
    /// Texture coordinates at the corners of those triangles, glTF convention (v down).
    pub uv: Option<Vec<[[f32; 2]; 3]>>,
}

/// The welded surface of a whole bundle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reconstruction {
    /// Positions \[m\], every one used.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals of the vertices, summed by area over all triangles around them.
    pub normals: Vec<[f32; 3]>,
    /// Vertex indices, piece after piece.
    pub triangles: Vec<[u32; 3]>,
    /// The pieces.
    pub pieces: Vec<ReconstructedPiece>,
}

impl Reconstruction {
    /// The positions as f64, for measuring.
    pub fn positions_f64(&self) -> Vec<[f64; 3]> {
        self.positions.iter().map(|p| p.map(f64::from)).collect()
    }
}

/// Triangulates every grid by shorter diagonals (one triangle where only three corners of a quad hold a particle) and
/// merges duplicates.
pub fn reconstruct(pieces: &[PieceView]) -> Result<Reconstruction> {
    let offsets = check(pieces)?;
    let representative = weld(pieces, &offsets)?;
    let mut out = Reconstruction::default();
    let mut vertex = vec![NONE; representative.len()];
    for (piece, &offset) in pieces.iter().zip(&offsets) {
        let start = out.triangles.len();
        let mut uv = piece.uv.map(|_| Vec::new());
        for t in triangles(piece) {
            let welded = t.map(|k| representative[offset + k as usize]);
            if welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0] {
                continue;
            }
            out.triangles.push(welded.map(|r| {
                if vertex[r as usize] == NONE {
                    vertex[r as usize] = out.positions.len() as u32;
                    let home = offsets.partition_point(|&o| o <= r as usize) - 1;
                    let [x, y, z, _] = pieces[home].position[r as usize - offsets[home]];
                    out.positions.push([x, y, z]);
                }
                vertex[r as usize]
            }));
            if let (Some(uv), Some(texels)) = (&mut uv, piece.uv) {
                uv.push(t.map(|k| texels[k as usize]));
            }
        }
        out.pieces.push(ReconstructedPiece { name: piece.name.into(), triangles: start..out.triangles.len(), uv });
    }
    out.normals = smooth_normals(&out.positions, &out.triangles);
    Ok(out)
}

fn fault(piece: &PieceView, problem: String) -> Error {
    let hint = "the bundle is damaged; build it again".into();
    Error::Piece { piece: piece.name.into(), stage: "reconstruct", problem, hint }
}

/// Array sizes and values; returns where each piece starts among the texels of all, in the order given.
fn check(pieces: &[PieceView]) -> Result<Vec<usize>> {
    let mut offsets = Vec::with_capacity(pieces.len());
    let mut total = 0usize;
    for piece in pieces {
        let n = piece.position.len();
        if piece.width.checked_mul(piece.height) != Some(n) || piece.uv.is_some_and(|uv| uv.len() != n) {
            let problem = format!("its maps do not have {} x {} texels", piece.width, piece.height);
            return Err(fault(piece, problem));
        }
        if let Some(k) = piece.position.iter().position(|p| p[3] != 0.0 && !p.iter().all(|x| x.is_finite())) {
            let problem = format!("texel ({}, {}) is not finite", k % piece.width, k / piece.width);
            return Err(fault(piece, problem));
        }
        let used = |k: usize| piece.position[k][3] != 0.0;
        let wrong = |uv: &[[f32; 2]]| (0..n).find(|&k| used(k) && !uv[k].iter().all(|x| x.is_finite()));
        if let Some(k) = piece.uv.and_then(wrong) {
            let (i, j) = (k % piece.width, k / piece.width);
            return Err(fault(piece, format!("the texture coordinates of texel ({i}, {j}) are not finite")));
        }
        offsets.push(total);
        total += n;
        if total >= 1 << 24 {
            return Err(fault(piece, "more than 2^24 - 2 texels in all".into()));
        }
    }
    Ok(offsets)
}

/// For each texel of all pieces the first of its duplicates.
fn weld(pieces: &[PieceView], offsets: &[usize]) -> Result<Vec<u32>> {
    let total = pieces.iter().map(|p| p.position.len()).sum();
    let mut sets = DisjointSets::new(total);
    let mut by_first: Vec<usize> = (0..pieces.len()).filter(|&p| !pieces[p].position.is_empty()).collect();
    by_first.sort_by_key(|&p| pieces[p].first_particle);
    for (piece, &offset) in pieces.iter().zip(offsets) {
        for (k, p) in piece.position.iter().enumerate() {
            let code = f64::from(p[3].abs());
            if code == 0.0 || code == 1.0 {
                continue;
            }
            let wrong = |what: &str| {
                let (i, j) = (k % piece.width, k / piece.width);
                fault(piece, format!("texel ({i}, {j}) has the particle code {}, {what}", p[3]))
            };
            if code < 2.0 || code.fract() != 0.0 {
                return Err(wrong("which is not 0, 1 or a whole number"));
            }
            let link = code - 2.0;
            let target = by_first.partition_point(|&p| f64::from(pieces[p].first_particle) <= link).checked_sub(1);
            let target = target.map(|t| by_first[t]).and_then(|t| {
                let local = (link - f64::from(pieces[t].first_particle)) as usize;
                pieces[t].position.get(local).filter(|q| q[3] != 0.0)?;
                Some(offsets[t] + local)
            });
            let target = target.ok_or_else(|| wrong("which leads to no particle"))?;
            sets.union((offset + k) as u32, target as u32);
        }
    }
    Ok(sets.into_representatives())
}

/// The triangles of one grid, as texels.
fn triangles(piece: &PieceView) -> Vec<[u32; 3]> {
    let (w, h) = (piece.width as u32, piece.height as u32);
    let present = |k: u32| piece.position[k as usize][3] != 0.0;
    let at = |k: u32| {
        let [x, y, z, _] = piece.position[k as usize].map(f64::from);
        [x, y, z]
    };
    let mut out = Vec::new();
    for j in 1..h {
        for i in 1..w {
            let c = j * w + i;
            let (a, b, d) = (c - w - 1, c - w, c - 1);
            match [a, b, c, d].map(present) {
                [true, true, true, true] => out.extend(split(a, b, c, d, at)),
                [false, true, true, true] => out.push([b, c, d]),
                [true, false, true, true] => out.push([a, c, d]),
                [true, true, false, true] => out.push([a, b, d]),
                [true, true, true, false] => out.push([a, b, c]),
                _ => {}
            }
        }
    }
    out
}

/// Unit vertex normals; (0, 0, 1) where the triangles around a vertex have no direction.
fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0; 3]; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize].map(f64::from));
        let n = cross(sub(b, a), sub(c, a));
        t.iter().for_each(|&v| sums[v as usize] = add(sums[v as usize], n));
    }
    let unit = |n: [f64; 3]| {
        let length = norm(n);
        if length > 0.0 && length.is_finite() { scale(n, 1.0 / length).map(|x| x as f32) } else { [0.0, 0.0, 1.0] }
    };
    sums.into_iter().map(unit).collect()
}

#[cfg(test)]
pub(crate) mod samples {
    use super::*;
    use crate::base::grid::Grid;

    /// The position map of a grid as written to a bundle.
    pub(crate) fn encode(g: &Grid, first_particle: u32) -> Vec<[f32; 4]> {
        let code = |k: usize| if g.links[k] == NONE { 1.0 } else { (first_particle + g.links[k] + 2) as f32 };
        (0..g.positions.len())
            .map(|k| {
                let [x, y, z] = g.positions[k].map(|x| x as f32);
                [x, y, z, if g.pinned[k] { -code(k) } else { code(k) }]
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::samples::encode;
    use super::*;
    use crate::base::grid::samples::*;
    use crate::base::topology::Topology;
    use proptest::prelude::*;

    fn view<'a>(g: &crate::base::grid::Grid, position: &'a [[f32; 4]], first_particle: u32) -> PieceView<'a> {
        PieceView { name: "body", width: g.width, height: g.height, first_particle, position, uv: None }
    }

    #[test]
    fn a_grid_comes_back_as_it_was_welded() {
        for mut g in [grid(6, 5, |u, v| [u, v, u * v]), cylinder(9, 5, 1.0, 2.0), torus(9, 8), sphere(9, 11)] {
            g.pinned[3] = true;
            let map = encode(&g, 0);
            let r = reconstruct(&[view(&g, &map, 0)]).unwrap();
            let (positions, triangles) = g.welded();
            assert_eq!((r.positions_f64(), &r.triangles), (positions, &triangles));
            assert!(r.normals.iter().all(|n| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5));
        }
    }

    #[test]
    fn two_pieces_are_welded_across() {
        // Two half cylinders, each with the other's index space after its own, listed in the wrong order.
        let half = |turn: f64| {
            grid(4, 3, move |u, v| {
                let a = std::f64::consts::PI * (u + turn);
                [a.cos(), v, a.sin()]
            })
        };
        let (g, f) = (half(0.0), half(1.0));
        let (mut a, mut b) = (encode(&g, 0), encode(&f, 12));
        for j in 0..3 {
            let (l, r) = (4 * j, 4 * j + 3);
            a[r][3] = (12 + l + 2) as f32;
            b[l][3] = (r + 2) as f32;
            b[r][3] = (l + 2) as f32;
            a[l][3] = (12 + r + 2) as f32;
        }
        let r = reconstruct(&[view(&f, &b, 12), view(&g, &a, 0)]).unwrap();
        let t = Topology::of(&r.triangles);
        assert_eq!((t.euler, t.boundary_loops, t.components), (0, 2, 1));
        assert!(t.is_oriented_manifold());
        assert_eq!(r.pieces[1].triangles, 12..24);
    }

    #[test]
    fn absent_texels_leave_single_triangles() {
        let g = grid(3, 3, |u, v| [u, v, 0.0]);
        for k in 0..9 {
            let mut map = encode(&g, 0);
            map[k] = [f32::NAN, 0.0, 0.0, 0.0];
            let r = reconstruct(&[view(&g, &map, 0)]).unwrap();
            let t = Topology::of(&r.triangles);
            assert_eq!(
                t.triangles,
                if k == 4 {
                    4
                } else if k % 2 == 0 {
                    7
                } else {
                    6
                }
            );
            // Without the middle the four corners touch at points only.
            assert!(t.singular_vertices == if k == 4 { 4 } else { 0 } && r.normals.iter().all(|n| n[2] > 0.99));
        }
    }

    #[test]
    fn damage_is_named() {
        let g = grid(3, 2, |u, v| [u, v, 0.0]);
        for (w, what) in [(1.5, "whole"), (2.5, "whole"), (8.0, "no particle"), (1e30, "no particle"), (0.5, "whole")] {
            let mut map = encode(&g, 0);
            map[4][3] = w;
            let e = reconstruct(&[view(&g, &map, 0)]).unwrap_err().to_string();
            assert!(e.contains(what) && e.contains("(1, 1)"), "{e}");
        }
        let mut map = encode(&g, 0);
        let mut uv = [[0.5; 2]; 6];
        for x in [f32::NAN, f32::INFINITY] {
            uv[4][1] = x;
            let e = reconstruct(&[PieceView { uv: Some(&uv), ..view(&g, &map, 0) }]).unwrap_err().to_string();
            assert!(e.contains("texture coordinates of texel (1, 1)"), "{e}");
        }
        // Where no particle is they mean nothing.
        map[4] = [0.0; 4];
        assert!(reconstruct(&[PieceView { uv: Some(&uv), ..view(&g, &map, 0) }]).is_ok());
        map[2][1] = f32::INFINITY;
        assert!(reconstruct(&[view(&g, &map, 0)]).unwrap_err().to_string().contains("(2, 0)"));
        assert!(reconstruct(&[PieceView { width: 5, ..view(&g, &map, 0) }]).is_err());
        assert!(reconstruct(&[PieceView { uv: Some(&[]), ..view(&g, &encode(&g, 0), 0) }]).is_err());
        assert_eq!(reconstruct(&[]).unwrap(), Reconstruction::default());
        let empty = PieceView { width: 0, height: 0, position: &[], ..view(&g, &[], 0) };
        assert!(reconstruct(&[empty]).unwrap().triangles.is_empty());
    }

    proptest! {
        #[test]
        fn any_codes_are_read_or_refused(
            codes in prop::collection::vec(prop_oneof![Just(0.0f32), Just(1.0), -40.0..40.0f32, (2..40i32).prop_map(|w| w as f32)], 30),
            x in prop::collection::vec(any::<f32>(), 30), first in 0u32..20,
        ) {
            let map: Vec<[f32; 4]> = codes.iter().zip(&x).map(|(&w, &x)| [x, -x, 0.5, w]).collect();
            let piece = PieceView { name: "p", width: 6, height: 5, first_particle: first, position: &map, uv: None };
            if let Ok(r) = reconstruct(&[piece]) {
                prop_assert_eq!(r.normals.len(), r.positions.len());
                prop_assert!(r.normals.iter().flatten().all(|x| x.is_finite()));
                prop_assert!(r.triangles.iter().flatten().all(|&v| (v as usize) < r.positions.len()));
                prop_assert!(crate::stage::export::glb(&r).is_ok());
            }
        }
    }
}
