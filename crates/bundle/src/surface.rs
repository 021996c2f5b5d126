//! The drawn surface of a piece: its triangles, and a frame at each of its points.
//!
//! Quads are split along (i, j)-(i+1, j+1), as the runtime draws them, and normals are those of its pass `normals`. The
//! preprocessor binds the vertices of `render.glb` to this surface, the runtime moves them with it, and both call the functions of
//! this module, so that a vertex at rest is where the source has it.

mod frame;
mod normals;

pub use frame::Frame;
pub use normals::surface_normals;

/// A point of the drawn surface of a piece: a triangle and weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The corners of the triangle, as texels of the piece (row by row, from 0). The second is the right neighbour of the first, so that
    /// the first edge leads along u.
    pub texels: [u32; 3],
    /// Weights of the second and the third corner; the first has the rest up to 1.
    pub weights: [f32; 2],
}

/// How far outside its triangle, in quads, a point may be by the rounding of u and v.
const OUTSIDE: f64 = 1e-2;

impl SurfacePoint {
    /// The point at (u, v), each 0 to 1, of a piece of `width` x `height` texels; `exists` tells which of its texels are particles.
    /// Where several triangles meet, the same one for the same numbers. `None` where no triangle is, and for numbers that are not finite.
    /// O(1).
    pub fn at((width, height): (u32, u32), exists: impl Fn(u32) -> bool, [u, v]: [f32; 2]) -> Option<SurfacePoint> {
        let inside = |t: f32| (0.0..=1.0).contains(&t);
        if width < 2 || height < 2 || !inside(u) || !inside(v) {
            return None;
        }
        let (x, y) = (f64::from(u) * f64::from(width - 1), f64::from(v) * f64::from(height - 1));
        let mut best: Option<(f64, SurfacePoint)> = None;
        for j in quads(y, height) {
            for i in quads(x, width) {
                let corner = j * width + i;
                for texels in triangles(corner, width, &exists) {
                    let place = |k: u32| [f64::from(k % width), f64::from(k / width)];
                    let weights = weights(texels.map(place), [x, y]);
                    let least = weights[0].min(weights[1]).min(1.0 - weights[0] - weights[1]);
                    if least >= -OUTSIDE && best.is_none_or(|b| least > b.0) {
                        best = Some((least, SurfacePoint { texels, weights: weights.map(|w| w as f32) }));
                    }
                }
            }
        }
        best.map(|b| b.1)
    }
}

/// The quads, by their first row or column, whose closed range has `x`, give or take rounding.
fn quads(x: f64, size: u32) -> std::ops::RangeInclusive<u32> {
    let quad = |x: f64| (x.max(0.0) as u32).min(size - 2);
    quad(x - OUTSIDE)..=quad(x + OUTSIDE)
}

/// The weights of the second and the third corner of a triangle of a grid at a point of its plane.
fn weights([a, b, c]: [[f64; 2]; 3], p: [f64; 2]) -> [f64; 2] {
    let [e, f, d] = [b, c, p].map(|q| [q[0] - a[0], q[1] - a[1]]);
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    // Half a quad each: the area is 1 or -1.
    let area = cross(e, f);
    [cross(d, f) / area, cross(e, d) / area]
}

/// The triangles of the quad whose upper left texel is `corner`, as the runtime draws them. In each the second texel is the right
/// neighbour of the first; nothing is said about the winding. The quad must lie on the grid.
pub fn triangles(corner: u32, width: u32, exists: impl Fn(u32) -> bool) -> impl Iterator<Item = [u32; 3]> {
    let [a, b, c, d] = [corner, corner + width, corner + width + 1, corner + 1];
    let (first, second) = match [a, b, c, d].map(exists) {
        [true, true, true, true] => (Some([b, c, a]), Some([a, d, c])),
        [false, true, true, true] => (Some([b, c, d]), None),
        [true, false, true, true] => (Some([a, d, c]), None),
        [true, true, false, true] => (Some([a, d, b]), None),
        [true, true, true, false] => (Some([b, c, a]), None),
        _ => (None, None),
    };
    first.into_iter().chain(second)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blend(point: &SurfacePoint, width: u32) -> [f64; 2] {
        let [a, b, c] = point.texels.map(|k| [f64::from(k % width), f64::from(k / width)]);
        let [s, t] = point.weights.map(f64::from);
        [0, 1].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]))
    }

    #[test]
    fn every_point_of_a_full_grid_is_in_its_triangle() {
        for (u, v) in (0..=40).flat_map(|i| (0..=40).map(move |j| (i as f32 / 40.0, j as f32 / 40.0))) {
            let point = SurfacePoint::at((7, 5), |_| true, [u, v]).unwrap();
            let [x, y] = blend(&point, 7);
            assert!((x - f64::from(u) * 6.0).abs() < 1e-6 && (y - f64::from(v) * 4.0).abs() < 1e-6);
            let least = point.weights[0].min(point.weights[1]).min(1.0 - point.weights[0] - point.weights[1]);
            assert!(least > -1e-6, "{point:?}");
            assert_eq!(point.texels[1], point.texels[0] + 1);
        }
    }

    #[test]
    fn a_quad_of_three_particles_has_one_triangle_and_one_of_two_has_none() {
        for gone in 0..4u32 {
            let exists = |k: u32| k != [0, 2, 3, 1][gone as usize];
            let all: Vec<[u32; 3]> = triangles(0, 2, exists).collect();
            assert!(all.len() == 1 && all[0].iter().all(|&k| exists(k)), "{all:?}");
            assert_eq!(all[0][1], all[0][0] + 1);
            let inside = [0.8, 0.2].map(|t: f32| [t, 1.0 - t]);
            let near = [[0.8, 0.8], inside[0], [0.2, 0.2], inside[1]][gone as usize];
            assert!(SurfacePoint::at((2, 2), exists, near).is_some());
            let far = [[0.2, 0.2], inside[1], [0.8, 0.8], inside[0]][gone as usize];
            assert!(SurfacePoint::at((2, 2), exists, far).is_none());
        }
        assert_eq!(triangles(0, 2, |k| k < 2).count(), 0);
    }

    #[test]
    fn a_border_next_to_a_hole_is_found_from_the_other_side() {
        // Only the left quad of two is there.
        let point = SurfacePoint::at((3, 2), |k| k % 3 < 2, [0.5, 0.3]).unwrap();
        assert!(point.texels.iter().all(|k| k % 3 < 2));
        assert_eq!(SurfacePoint::at((3, 2), |k| k % 3 < 2, [0.7, 0.3]), None);
        for bad in [[f32::NAN, 0.0], [0.0, 1.5], [-0.1, 0.5]] {
            assert_eq!(SurfacePoint::at((3, 2), |_| true, bad), None);
        }
    }
}
