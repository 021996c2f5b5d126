//! Shapes that can be unrolled: the image of a rectangle is the rectangle, and that of a tube its sheet.

use gimage::options::ImageSize;
use gimage::pipeline::Built;
use gimage_bundle::MapKind;
use gimage_tests::shapes::{Random, Shape, sheet};
use gimage_tests::{build_shape, check, point, texels, texels_of};

/// A rectangle of `ex` x `ey` metres.
fn rectangle(ex: f64, ey: f64, nx: usize, ny: usize) -> Shape {
    sheet(nx, ny, &mut Random(1), |u, v| [ex * u, 0.0, -ey * v])
}

/// The same, its inner vertices moved about within the plane, and the vertices of its sides along them.
fn irregular(ex: f64, ey: f64, nx: usize, ny: usize, seed: u64) -> Shape {
    let mut random = Random(seed);
    let (mut shape, step) =
        (sheet(nx, ny, &mut random, |u, v| [ex * u, 0.0, -ey * v]), [ex / nx as f64, ey / ny as f64]);
    for k in 0..shape.positions.len() {
        let (i, j) = (k % (nx + 1), k / (nx + 1));
        let p = &mut shape.positions[k];
        if i != 0 && i != nx {
            p[0] += 0.3 * step[0] * random.signed();
        }
        if j != 0 && j != ny {
            p[2] += 0.3 * step[1] * random.signed();
        }
    }
    shape
}

/// Turned about no axis in particular.
fn turned(shape: Shape) -> Shape {
    let (s, c) = 0.6f64.sin_cos();
    shape.moved(|p| {
        let q = [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]];
        [q[0], c * q[1] - s * q[2], s * q[1] + c * q[2]]
    })
}

/// Flaws of the image of a rectangle.
fn not_flat(built: &Built, sides: [f64; 2]) -> Vec<String> {
    let mut wrong = Vec::new();
    let piece = &built.bundle.manifest.pieces[0];
    let (w, h) = (f64::from(piece.width - 1), f64::from(piece.height - 1));
    let size = format!("{} x {}", piece.width, piece.height);
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-5;
    // Either side may lie along the rows.
    let fits = |r: [f32; 4], [ex, ey]: [f64; 2]| {
        let (dx, dy) = (ex / w, ey / h);
        let want = [dx, dy, dx.hypot(dy), dx.hypot(dy)];
        r.iter().zip(want).all(|(&r, want)| close(f64::from(r), want))
    };
    match piece.constants.rest {
        Some(r) if fits(r, sides) || fits(r, [sides[1], sides[0]]) => {}
        Some(r) => wrong.push(format!("{size}: constant rest lengths {r:?} for sides of {sides:?} m")),
        None => {
            let range = |c: usize| {
                let image = built.bundle.image(0, &MapKind::Rest).unwrap();
                let all = || image.data.chunks_exact(4).map(move |r| r[c]).filter(|r| *r > 0.0);
                (all().fold(f32::MAX, f32::min), all().fold(0.0, f32::max))
            };
            let l2 = piece.quality.stretch_l2;
            wrong.push(format!("{size}: rest lengths right {:?}, down {:?}, L2 stretch {l2:?}", range(0), range(1)));
        }
    }
    if built.bundle.image(0, &MapKind::Rest).is_some() && piece.constants.rest.is_some() {
        wrong.push("rest lengths both ways".into());
    }
    // Border texels stand for half a cell and corners for a quarter; the mass of the whole is that of the cloth.
    let total: f64 = match piece.constants.mass {
        Some(m) => f64::from(m) * f64::from(piece.width * piece.height),
        None => built.bundle.image(0, &MapKind::Mass).unwrap().data.iter().map(|&m| f64::from(m)).sum(),
    };
    let want = piece.constants.density.unwrap() * sides[0] * sides[1];
    if (total / want - 1.0).abs() > 1e-4 {
        wrong.push(format!("{size}: {total} kg instead of {want}"));
    }
    wrong
}

fn cases() -> Vec<(&'static str, Shape, [f64; 2])> {
    vec![
        ("regular square", rectangle(1.0, 1.0, 10, 10), [1.0, 1.0]),
        ("regular rectangle", rectangle(1.5, 0.6, 15, 6), [1.5, 0.6]),
        ("regular rectangle, turned", turned(rectangle(1.5, 0.6, 15, 6)), [1.5, 0.6]),
        ("irregular square", irregular(1.0, 1.0, 12, 12, 5), [1.0, 1.0]),
        ("irregular rectangle", irregular(0.8, 1.7, 9, 20, 6), [0.8, 1.7]),
        ("irregular rectangle, turned", turned(irregular(0.8, 1.7, 9, 20, 7)), [0.8, 1.7]),
        ("two triangles", rectangle(1.0, 0.5, 1, 1), [1.0, 0.5]),
    ]
}

#[test]
fn rectangles_have_constant_rest_lengths() {
    let mut wrong = Vec::new();
    for (name, shape, sides) in cases() {
        for (how, options) in [("point", point(1024)), ("fit", texels(1024))] {
            let built = build_shape(&shape, &options).unwrap();
            check(name, &built);
            wrong.extend(not_flat(&built, sides).iter().map(|w| format!("{name}, {how}: {w}")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn an_exact_size_is_kept() {
    let mut wrong = Vec::new();
    for (w, h, shape) in [
        (64, 64, rectangle(1.0, 1.0, 10, 10)),
        (64, 64, irregular(1.0, 1.0, 12, 12, 5)),
        (33, 17, rectangle(1.0, 1.0, 7, 7)),
    ] {
        let mut options = point(9);
        options.image.size = ImageSize::Exact(w, h);
        let built = build_shape(&shape, &options).unwrap();
        check("square", &built);
        let piece = &built.bundle.manifest.pieces[0];
        assert_eq!((piece.width, piece.height), (w, h));
        wrong.extend(not_flat(&built, [1.0, 1.0]).iter().map(|m| format!("{w} x {h}: {m}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn masses_are_those_of_the_cells() {
    let built = build_shape(&rectangle(1.0, 1.0, 10, 10), &point(1024)).unwrap();
    let piece = &built.bundle.manifest.pieces[0];
    let (w, h) = (piece.width as usize, piece.height as usize);
    let whole = piece.constants.density.unwrap() / ((w - 1) * (h - 1)) as f64;
    if let Some(m) = piece.constants.mass {
        assert!((f64::from(m) / whole - 1.0).abs() < 0.1, "{m} kg, a cell weighs {whole}");
        return;
    }
    let mass = built.bundle.image(0, &MapKind::Mass).unwrap();
    for j in 1..h - 1 {
        for i in 1..w - 1 {
            let m = f64::from(mass.at(j * w + i)[0]);
            assert!((m / whole - 1.0).abs() < 1e-4, "texel ({i}, {j}): {m} kg, a cell weighs {whole}");
        }
    }
}

#[test]
fn corners_of_the_rectangle_are_corners_of_the_image() {
    let built = build_shape(&irregular(1.5, 0.6, 15, 6, 9), &point(1024)).unwrap();
    let piece = &built.bundle.manifest.pieces[0];
    let (w, h) = (piece.width as usize, piece.height as usize);
    let all = texels_of(&built.bundle, 0);
    for k in [0, w - 1, w * h - 1, w * (h - 1)] {
        let [x, y, z, _] = all[k];
        let at = |a: f32, b: f32| a.abs() < 1e-6 || (a.abs() - b).abs() < 1e-6;
        assert!(at(x, 1.5) && y.abs() < 1e-6 && at(z, 0.6), "corner {k} is at {x}, {y}, {z}");
    }
}

#[test]
fn a_tube_unrolls() {
    use std::f64::consts::TAU;
    for (radius, height, around, along) in [(0.3, 0.8, 96, 24), (0.5, 0.4, 120, 12)] {
        let mut shape = Shape::default();
        for j in 0..=along {
            for i in 0..around {
                let a = TAU * i as f64 / around as f64;
                let y = height * j as f64 / along as f64;
                shape.positions.push([radius * a.cos(), y, radius * a.sin()]);
            }
        }
        for j in 0..along {
            for i in 0..around {
                let at = |i: usize, j: usize| (j * around + i % around) as u32;
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                shape.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let built = build_shape(&shape, &point(4096)).unwrap();
        check("tube", &built);
        let piece = &built.bundle.manifest.pieces[0];
        let stretch = piece.quality.stretch_l2.unwrap();
        assert!(
            stretch < 1.01,
            "radius {radius}, height {height}: {} x {}, L2 stretch {stretch}",
            piece.width,
            piece.height
        );
    }
}
