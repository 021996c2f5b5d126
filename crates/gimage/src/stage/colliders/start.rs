//! Where clothes start: outside of the surface of a body, or inside of it.

use gimage_bundle::{Body, Bundle, MapKind};
use rayon::prelude::*;

use super::winding;
use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::vec3::{cross, dot, sub};

/// A particle deeper \[m\] inside than this starts inside: a runtime leaves it there, and its neighbours outside.
const INSIDE_M: f64 = 0.005;
/// Share of the free particles that may start inside for [`super::Tier::Auto`] to take the surface.
const MAX_SHARE: f64 = 0.01;
/// Triangles of a surface that it takes, at most: a runtime has 150 bytes per vertex.
const MAX_TRIANGLES: usize = 200_000;
/// Winding number from which a point is inside.
const WOUND: f64 = 0.5;

/// Where the free particles of a bundle start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Start {
    /// Free particles.
    pub free: usize,
    /// Those of them that start more than 5 mm inside.
    pub inside: usize,
    /// Depth \[m\] of the deepest one of them, 0 without any.
    pub deepest: f64,
}

impl Start {
    /// Measures a bundle that has its positions. O(n log n).
    pub fn of(bundle: &Bundle, body: &Body) -> Self {
        let mesh = Mesh {
            positions: body.positions.iter().map(|p| p.map(f64::from)).collect(),
            triangles: body.triangles.clone(),
            ..Mesh::default()
        };
        let (closest, winding) = (Closest::new(&mesh.positions, &mesh.triangles), winding(&mesh));
        let texels = |piece: usize| bundle.image(piece, &MapKind::Position).into_iter().flat_map(|i| i.data.chunks(4));
        let free: Vec<[f64; 3]> = (0..bundle.manifest.pieces.len())
            .flat_map(texels)
            .filter(|p| p[3] > 0.0)
            .map(|p| [p[0], p[1], p[2]].map(f64::from))
            .collect();
        let depth = |p: &[f64; 3]| -> Option<f64> {
            let near = closest.project(*p).filter(|near| near.distance > INSIDE_M)?;
            let [a, b, c] = mesh.corners(near.triangle as usize);
            let is_behind = dot(sub(*p, near.point), cross(sub(b, a), sub(c, a))) <= 0.0;
            (is_behind && winding.number(*p) > WOUND).then_some(near.distance)
        };
        let depths: Vec<f64> = free.par_iter().filter_map(depth).collect();
        let deepest = depths.iter().copied().fold(0.0, f64::max);
        Start { free: free.len(), inside: depths.len(), deepest }
    }

    /// Whether the surface of a body is the better collider for clothes that start here.
    pub fn suits(&self, body: &Body) -> bool {
        self.inside as f64 <= MAX_SHARE * self.free as f64 && body.triangles.len() <= MAX_TRIANGLES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gimage_bundle::Image;

    /// A box from 0 to 1 m.
    fn cube() -> Body {
        let at = |k: usize| [0, 1, 2].map(|c| if k >> c & 1 == 1 { 1.0 } else { 0.0 });
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Body { positions: (0..8).map(at).collect(), triangles, ..Body::default() }
    }

    #[test]
    fn free_particles_inside_are_counted_and_decide() {
        let mut bundle = Bundle::new("test");
        let piece = bundle.add_piece("cloth", 20, 10).unwrap();
        // In rows from 0.1 m above the box down to 0.08 m inside it; the first column is pinned.
        let texel = |k: usize| {
            let (i, j) = (k % 20, k / 20);
            [0.3 + 0.01 * i as f32, 1.1 - 0.02 * j as f32, 0.5, if i == 0 { -1.0 } else { 1.0 }]
        };
        let data = (0..200).flat_map(texel).collect();
        bundle.insert(piece, MapKind::Position, Image { width: 20, height: 10, channels: 4, data }).unwrap();
        let start = Start::of(&bundle, &cube());
        assert_eq!((start.free, start.inside), (190, 4 * 19));
        assert!((start.deepest - 0.08).abs() < 1e-6, "{start:?}");
        assert!(!start.suits(&cube()));
        assert!(Start { free: 190, inside: 1, deepest: 0.1 }.suits(&cube()));
    }
}
