//! A mapped disk -> texels: which triangle, and where in it, each texel of the image falls.

use crate::stage::border::{BorderTexel, on_rectangle};
use crate::stage::cut::disk::Disk;
use crate::stage::parameterize::distortion::{planar, signed_area2};

/// Where one texel lies on the disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Disk triangle.
    pub triangle: u32,
    /// Barycentric coordinates in it, summing to 1.
    pub bary: [f64; 3],
}

impl Sample {
    /// The point on the disk \[m\].
    pub(crate) fn position(&self, disk: &Disk) -> [f64; 3] {
        let t = disk.triangles[self.triangle as usize];
        let mut p = [0.0; 3];
        for (share, v) in self.bary.iter().zip(t) {
            p.iter_mut().zip(disk.positions[v as usize]).for_each(|(p, x)| *p += share * x);
        }
        p
    }
}

/// Index of the texel at border step `p` of a `w` x `h` cell image.
pub(crate) fn border_index(p: u32, w: u32, h: u32) -> usize {
    let [i, j] = on_rectangle(f64::from(p), w, h);
    j as usize * (w as usize + 1) + i as usize
}

/// One sample a texel, row by row. Border texels are where the border put them; inner ones in the triangle that
/// contains them, the most central one where rounding leaves a choice. `None` if a texel is in no triangle, which a
/// flip-free map of the whole rectangle rules out. O(triangles + texels).
pub(crate) fn resample(disk: &Disk, uv: &[[f64; 2]], texels: &[BorderTexel], w: u32, h: u32) -> Option<Vec<Sample>> {
    let (columns, rows) = (w as usize + 1, h as usize + 1);
    let mut best = vec![(f64::NEG_INFINITY, Sample { triangle: u32::MAX, bary: [0.0; 3] }); columns * rows];
    for (f, &t) in disk.triangles.iter().enumerate() {
        let p = planar(uv, t);
        let area = signed_area2(p);
        if area <= 0.0 {
            continue;
        }
        let range = |c: usize, top: u32| {
            let lo = p.iter().map(|q| q[c]).fold(f64::INFINITY, f64::min);
            let hi = p.iter().map(|q| q[c]).fold(f64::NEG_INFINITY, f64::max);
            let (lo, hi) = ((lo - 1e-9).ceil().max(1.0), (hi + 1e-9).floor().min(f64::from(top) - 1.0));
            (lo as usize, hi)
        };
        let ((i0, i1), (j0, j1)) = (range(0, w), range(1, h));
        let mut j = j0;
        while j as f64 <= j1 {
            let mut i = i0;
            while i as f64 <= i1 {
                let q = [i as f64, j as f64];
                let b1 = signed_area2([p[0], q, p[2]]) / area;
                let b2 = signed_area2([p[0], p[1], q]) / area;
                let bary = [1.0 - b1 - b2, b1, b2];
                let inside = bary.iter().copied().fold(f64::INFINITY, f64::min);
                let at = j * columns + i;
                if inside > best[at].0 && inside > -1e-6 {
                    best[at] = (inside, Sample { triangle: f as u32, bary });
                }
                i += 1;
            }
            j += 1;
        }
    }
    for (p, t) in texels.iter().enumerate() {
        best[border_index(p as u32, w, h)] = (1.0, Sample { triangle: t.triangle, bary: t.bary });
    }
    best.into_iter()
        .map(|(_, mut s)| {
            if s.triangle == u32::MAX {
                return None;
            }
            s.bary = s.bary.map(|b| b.clamp(0.0, 1.0));
            let sum: f64 = s.bary.iter().sum();
            s.bary = s.bary.map(|b| b / sum);
            Some(s)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::locate::Locator;
    use crate::base::shapes;
    use crate::stage::parameterize::distortion::flips;

    #[test]
    fn every_sample_maps_back_to_its_texel_and_the_locator_agrees() {
        for (name, s) in shapes::all() {
            let m = shapes::mapped(&s, 24, 20);
            assert_eq!(flips(&m.disk.triangles, &m.uv), 0, "{name}");
            let locator = Locator::new(&m.disk, &m.uv, m.w as usize, m.h as usize);
            let columns = m.w as usize + 1;
            for (k, sample) in m.samples.iter().enumerate() {
                let at = [(k % columns) as f64, (k / columns) as f64];
                let p = planar(&m.uv, m.disk.triangles[sample.triangle as usize]);
                let found = locator.at(at).unwrap();
                for c in 0..2 {
                    let x: f64 = (0..3).map(|i| sample.bary[i] * p[i][c]).sum();
                    assert!((x - at[c]).abs() < 1e-9, "{name}: texel {k}");
                }
                let (a, b) = (sample.position(&m.disk), found.position(&m.disk));
                assert!(crate::base::vec3::distance(a, b) < 1e-6, "{name}: texel {k}");
            }
            assert!(locator.at([-0.1, 1.0]).is_none() && locator.at([1.0, f64::NAN]).is_none());
            assert_eq!(m.texels.len() as u32, 2 * (m.w + m.h));
            assert!(!m.border.nodes.is_empty());
        }
    }
}
