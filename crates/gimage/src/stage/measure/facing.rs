//! How the triangles of an image face, beside the surface that they were sampled from.
//!
//! A triangle of the image is compared with the source at the places of its own three texels, on the disk, whose
//! triangles all wind one way. Nearest points are not asked: one-sided surfaces, which have no outside, and thin double
//! shells, where the nearest point is often on the other sheet, are compared as they were sampled.

use crate::base::grid::Grid;
use crate::base::vec3::{cross, dot, norm, normalize, sub};
use crate::stage::cut::disk::Disk;
use crate::stage::sample::resample::Sample;

/// How an image's triangles face. Shares and means are by the area of the image's triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Facing {
    /// Share of the image's area, 0..=1, in triangles that face against the source's normals at all their texels. A
    /// triangle across a sharp crease faces with one side of it.
    pub fold_area: f64,
    /// Mean angle between the normal of an image's triangle and the source's normals at its texels \[degrees\], 0..=180.
    pub normal_degrees: f64,
}

/// Compares the image's triangles with the disk's triangles that their texels were sampled from.
///
/// `samples` has one entry per texel of `grid`. Triangles without an area, of the image or of the disk, do not count; all
/// 0 if nothing is left, and 180 degrees, all folded, where a position is not finite. O(texels), no queries.
pub(crate) fn facing(disk: &Disk, samples: &[Sample], grid: &Grid) -> Facing {
    let normals: Vec<[f64; 3]> = samples
        .iter()
        .map(|s| {
            let [a, b, c] = disk.triangles[s.triangle as usize].map(|v| disk.positions[v as usize]);
            // Sides are scaled before they are multiplied: triangles of any size keep their normals.
            normalize(cross(normalize(sub(b, a)), normalize(sub(c, a))))
        })
        .collect();
    let triangles = grid.triangulate();
    // In units of the largest side, so that areas of tiny and huge garments neither vanish nor overflow.
    let side = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| grid.stored(k));
        norm(sub(b, a)).max(norm(sub(c, a)))
    };
    let unit = triangles.iter().map(side).fold(0.0, f64::max);
    if !unit.is_finite() || triangles.iter().flatten().any(|&k| grid.stored(k).iter().any(|x| !x.is_finite())) {
        return Facing { fold_area: 1.0, normal_degrees: 180.0 };
    }
    let (mut total, mut folded, mut weight, mut degrees) = (0.0, 0.0, 0.0, 0.0);
    for t in &triangles {
        let [a, b, c] = t.map(|k| grid.stored(k));
        let normal = cross(sub(b, a).map(|x| x / unit), sub(c, a).map(|x| x / unit));
        let area = 0.5 * norm(normal);
        let of_texels = t.map(|k| normals[k as usize]);
        let known = of_texels.iter().filter(|n| **n != [0.0; 3]);
        if area == 0.0 || known.clone().next().is_none() {
            continue;
        }
        total += area;
        folded += if known.clone().all(|&n| dot(normal, n) < 0.0) { area } else { 0.0 };
        let normal = normalize(normal);
        for &n in known {
            weight += area;
            degrees += area * dot(normal, n).clamp(-1.0, 1.0).acos().to_degrees();
        }
    }
    if total == 0.0 {
        return Facing::default();
    }
    Facing { fold_area: folded / total, normal_degrees: degrees / weight }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use crate::base::surface::Surface;
    use crate::options::{BuildOptions, ImageSize};
    use crate::stage::component::{ComponentOptions, extract, split};
    use crate::stage::image::{ImageOptions, PieceImage, image};
    use crate::stage::import::{ImportOptions, import};
    use crate::stage::repair::{RepairOptions, repair};

    fn made(surface: &Surface, texels: u32) -> PieceImage {
        let mut options = BuildOptions::default();
        options.image.size = ImageSize::Texels(texels);
        image("piece", surface, None, &ImageOptions::new(&options, None)).unwrap()
    }

    fn of(image: &PieceImage) -> Facing {
        facing(&image.disk, &image.samples, &image.grid)
    }

    #[test]
    fn one_sided_surfaces_do_not_count_as_folded() {
        for (name, s) in [
            ("moebius", shapes::moebius(48, 8)),
            ("klein", shapes::klein(32, 24)),
            ("projective plane", shapes::projective_plane(3)),
            ("torus", shapes::torus(24, 16)),
            ("tube", shapes::tube(24, 12, 1.0)),
        ] {
            let f = of(&made(&s, 4096));
            assert!(f.fold_area < 0.002 && f.normal_degrees < 12.0, "{name}: {f:?}");
        }
    }

    #[test]
    fn one_sided_files_do_not_count_as_folded() {
        let Some(shared) = crate::base::shapes::shared_garments() else { return };
        for name in ["moebius.obj", "klein_bottle.obj"] {
            let mesh = import(&shared.join("bad").join(name), &ImportOptions::default()).unwrap().mesh;
            let mesh = repair(mesh, &RepairOptions::default()).unwrap().mesh;
            let parts = split(&mesh, &ComponentOptions::default());
            assert!(!parts.pieces[0].orientable, "{name}");
            let f = of(&made(&extract(&mesh, &parts.pieces[0]), 4096));
            assert!(f.fold_area < 0.002 && f.normal_degrees < 12.0, "{name}: {f:?}");
        }
    }

    /// Two sheets 1e-6 m apart: the nearest point is as often on the other one.
    #[test]
    fn thin_double_shells_do_not_count_as_folded() {
        let s = shapes::sheet(24, 12, shapes::Join::Same, shapes::Join::Open, |u, v| {
            let x = if u < 0.5 { u } else { 1.0 - u };
            [x, v, if u < 0.5 { 0.0 } else { 1e-6 }]
        });
        let f = of(&made(&s, 2048));
        assert!(f.fold_area < 0.002 && f.normal_degrees < 12.0, "{f:?}");
    }

    #[test]
    fn triangles_turned_over_are_counted_by_area() {
        let s = shapes::rectangle(8, 8, 1.0, 1.0);
        let mut image = made(&s, 33 * 33);
        assert!(of(&image).fold_area == 0.0 && of(&image).normal_degrees < 1e-3);
        // Mirrored, all of it faces the other way, on a surface that is flat or far away alike.
        for far in [0.0, 1e4] {
            let mut turned = image.grid.clone();
            turned.positions.iter_mut().for_each(|p| *p = [far - p[0], p[1], 0.0]);
            let f = facing(&image.disk, &image.samples, &turned);
            assert!(f.fold_area > 0.99 && f.normal_degrees > 170.0, "{f:?}");
        }
        // A texel pulled over its neighbours turns triangles of known area over.
        let (w, at) = (image.grid.width, image.grid.width * (image.grid.height / 2) + image.grid.width / 2);
        let step = crate::base::vec3::distance(image.grid.positions[at], image.grid.positions[at + 1]);
        let along = sub(image.grid.positions[at + 1], image.grid.positions[at]);
        image.grid.positions[at] = crate::base::vec3::add(image.grid.positions[at], along.map(|x| 3.0 * x));
        let f = of(&image);
        let cells = ((w - 1) * (image.grid.height - 1)) as f64;
        assert!(step > 0.0 && f.fold_area > 1.0 / cells && f.fold_area < 8.0 / cells, "{f:?} of {cells} cells");
    }

    #[test]
    fn wrecks_are_folded() {
        let image = made(&shapes::sphere(24, 12), 2048);
        let mut wreck = image.grid.clone();
        let mut draw = shapes::random(3);
        wreck.positions.iter_mut().for_each(|p| *p = [0, 1, 2].map(|_| draw(1000) as f64));
        let f = facing(&image.disk, &image.samples, &wreck);
        assert!((0.3..0.6).contains(&f.fold_area) && (80.0..100.0).contains(&f.normal_degrees), "{f:?}");
        wreck.positions[5] = [f64::NAN; 3];
        assert_eq!(facing(&image.disk, &image.samples, &wreck), Facing { fold_area: 1.0, normal_degrees: 180.0 });
    }

    #[test]
    fn scale_and_place_do_not_matter() {
        let s = shapes::torus(24, 16);
        let image = made(&s, 2048);
        let as_it_is = of(&image);
        for scale in [1e-18, 1e18] {
            let mut moved = made(&s, 2048);
            moved.disk.positions.iter_mut().flatten().for_each(|x| *x *= scale);
            moved.grid.positions.iter_mut().flatten().for_each(|x| *x *= scale);
            let f = of(&moved);
            assert!((f.normal_degrees - as_it_is.normal_degrees).abs() < 1e-3, "{f:?} {as_it_is:?}");
            assert!((f.fold_area - as_it_is.fold_area).abs() < 1e-3);
        }
    }
}
