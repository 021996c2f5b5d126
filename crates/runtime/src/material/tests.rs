use super::cell::cells;
use super::*;
use crate::cloth::Membrane;
use crate::{Cloth, Flat, Grid, Mass, Particle, Parts, Rest};

/// A sheet of 0.8 m x 1 m with `w` x `h` particles whose grid is not that of the fabric: `skew` moves and turns it.
/// Texture coordinates are positions.
fn sheet(w: u32, h: u32, skew: f64) -> Cloth {
    let at = |k: u32| {
        let (u, v) = (f64::from(k % w) / f64::from(w - 1), f64::from(k / w) / f64::from(h - 1));
        let bump = skew * (3.0 * u + 2.0 * v).sin() * 0.3;
        [0.8 * u + bump * u + 0.8 * skew * v, v + bump * v - 0.3 * skew * u]
    };
    let plane: Vec<[f64; 2]> = (0..w * h).map(at).collect();
    let far = |a: u32, b: u32| {
        let (a, b) = (plane[a as usize], plane[b as usize]);
        (a[0] - b[0]).hypot(a[1] - b[1]) as f32
    };
    let rest = (0..w * h).map(|k| {
        let (right, down, up) = (k % w + 1 < w, k / w + 1 < h, k >= w);
        let to = |there: bool, other: u32| if there { far(k, other) } else { 0.0 };
        [to(right, k + 1), to(down, k + w), to(right && down, k + w + 1), to(right && up, (k + 1).wrapping_sub(w))]
    });
    let parts = Parts {
        name: "sheet".into(),
        grids: vec![Grid { name: "g".into(), first: 0, width: w, height: h }],
        positions: plane.iter().map(|p| [p[0] as f32, p[1] as f32, 0.0]).collect(),
        particles: vec![Particle::Free { next: None }; (w * h) as usize],
        rest: Rest::Image(rest.collect()),
        mass: Mass::Constant(1.0),
    };
    let mut cloth = Cloth::new(parts).unwrap();
    cloth.set_grain(Some(plane.iter().map(|p| p.map(|x| x as f32)).collect())).unwrap();
    cloth
}

fn area(cloth: &Cloth) -> f64 {
    cells(cloth, 0, &cloth.points()).map(|c| membrane::area(&c)).sum()
}

/// Energy of the membrane where positions are moved by `to`.
fn tension(cloth: &Cloth, to: impl Fn([f32; 3]) -> [f64; 3]) -> f64 {
    let Membrane { cells, soft, .. } = cloth.membrane().unwrap();
    let width = cloth.grids()[0].width as usize;
    let at: Vec<[f64; 3]> = cloth.positions().iter().map(|p| to(*p)).collect();
    let mut sum = 0.0;
    for (n, q) in cells.iter().enumerate() {
        let [a, b, c, d] = q.map(f64::from);
        let det = a * d - b * c;
        if det == 0.0 {
            continue;
        }
        let k = n / 2;
        let circle = [k, k + 1, k + width + 1, k + width];
        let of = |m: usize| at[circle[(m + usize::from(det < 0.0)) % 4]];
        let corners = if n % 2 == 0 { [of(0), of(1), of(2)] } else { [of(0), of(2), of(3)] };
        let side = |m: usize| [0, 1, 2].map(|x| corners[m][x] - corners[0][x]);
        let (e, h) = (side(1), side(2));
        let weft = [0, 1, 2].map(|x| a * e[x] + c * h[x]);
        let warp = [0, 1, 2].map(|x| b * e[x] + d * h[x]);
        let dot = |x: [f64; 3], y: [f64; 3]| (0..3).map(|n| x[n] * y[n]).sum::<f64>();
        let strains = [dot(weft, weft).sqrt() - 1.0, dot(warp, warp).sqrt() - 1.0, dot(weft, warp)];
        let energy: f64 = strains.iter().zip(soft).map(|(s, soft)| s * s / f64::from(*soft)).sum();
        sum += energy / (4.0 * det.abs());
    }
    sum
}

/// Energy of bending where positions are moved by `to`.
fn bent(cloth: &Cloth, to: impl Fn([f32; 3]) -> [f64; 3]) -> f64 {
    let bending = cloth.bending().unwrap();
    let at: Vec<[f64; 3]> = cloth.positions().iter().map(|p| to(*p)).collect();
    let same = cloth.points();
    let mut moments = vec![[0.0; 3]; at.len()];
    for (g, grid) in cloth.grids().iter().enumerate() {
        for (local, d) in (0..grid.texels()).flat_map(|k| (0..4).map(move |d| (k, d))) {
            let k = grid.first as usize + local;
            let Some(other) = cloth.neighbour(g, local, d) else { continue };
            for x in 0..3 {
                let m = f64::from(bending.weights[k][d]) * (at[other][x] - at[k][x]);
                moments[same[k] as usize][x] += m;
                moments[same[other] as usize][x] -= m;
            }
        }
    }
    let points = (0..at.len()).filter(|k| same[*k] as usize == *k && bending.compliance[*k] > 0.0);
    points.map(|k| moments[k].iter().map(|m| m * m).sum::<f64>() / (2.0 * f64::from(bending.compliance[k]))).sum()
}

const FABRIC: Material = Material {
    warp: 300.0,
    weft: 200.0,
    shear: 30.0,
    bend: 2e-4,
    density: 0.2,
    damping: 0.5,
    thickness: None,
    friction: 1.0,
};

#[test]
fn the_energy_of_a_strain_is_that_of_the_sheet_on_any_grid() {
    for (w, h, skew) in [(9, 9, 0.0), (9, 33, 0.0), (17, 12, 0.3), (24, 31, -0.5)] {
        let mut cloth = sheet(w, h, skew);
        cloth.set_material(&FABRIC).unwrap();
        let whole = area(&cloth);
        for (weft, warp, shear) in [(0.02, 0.0, 0.0), (0.0, -0.03, 0.0), (0.0, 0.0, 0.04), (0.01, 0.02, -0.03)] {
            // v is the warp: the second coordinate.
            let to = |p: [f32; 3]| {
                let (x, y) = (f64::from(p[0]), f64::from(p[1]));
                [(1.0 + weft) * x + shear * y, (1.0 + warp) * y, 0.0]
            };
            let along: f64 = shear.hypot(1.0 + warp) - 1.0;
            let angle = (1.0 + weft) * shear;
            let true_energy =
                0.5 * whole * (FABRIC.weft * weft * weft + FABRIC.warp * along * along + FABRIC.shear * angle * angle);
            let energy = tension(&cloth, to);
            assert!((energy / true_energy - 1.0).abs() < 2e-3, "{w} x {h}, {skew}: {energy} for {true_energy}");
        }
        // Turned as a whole it costs nothing.
        let (s, c) = 1.1f64.sin_cos();
        let turned =
            |p: [f32; 3]| [c * f64::from(p[0]) - s * f64::from(p[1]), 0.3, s * f64::from(p[0]) + c * f64::from(p[1])];
        assert!(tension(&cloth, turned) < 1e-9 * whole * FABRIC.warp);
        assert!((cloth.total_mass() / (whole * FABRIC.density) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn the_energy_of_a_bent_sheet_is_that_of_the_plate_on_any_grid() {
    for (w, h, skew) in [(17, 17, 0.0), (12, 40, 0.0), (24, 20, 0.3), (40, 40, -0.5)] {
        let mut cloth = sheet(w, h, skew);
        cloth.set_material(&FABRIC).unwrap();
        let whole = area(&cloth);
        for angle in [0.0f64, 0.4, 1.2, 2.5] {
            let (radius, (s, c)) = (0.7, angle.sin_cos());
            // Rolled up about an axis in the plane.
            let to = |p: [f32; 3]| {
                let (x, y) = (f64::from(p[0]), f64::from(p[1]));
                let (along, across) = (c * x + s * y, c * y - s * x);
                [across, radius * (along / radius).sin(), radius * (along / radius).cos()]
            };
            let true_energy = 0.5 * FABRIC.bend * whole / (radius * radius);
            let energy = bent(&cloth, to);
            assert!(
                (energy / true_energy - 1.0).abs() < 0.02,
                "{w} x {h}, {skew}, {angle}: {energy} for {true_energy}"
            );
        }
        // Stretched in its plane it does not bend, and a border has no moment.
        let flat = |p: [f32; 3]| [1.1 * f64::from(p[0]), 0.2 * f64::from(p[0]) + f64::from(p[1]), 0.5];
        assert!(bent(&cloth, flat) < 1e-9, "{}", bent(&cloth, flat));
        assert_eq!(cloth.bending().unwrap().compliance[w as usize], 0.0);
    }
}

/// The same sheet as one grid, and as two that are sewn where the middle column was.
fn sewn(n: u32) -> [Cloth; 2] {
    let whole = Flat { width: 2 * n - 1, ..Flat::square("whole", n) }.cloth().unwrap();
    let (mut positions, mut particles) = (Vec::new(), Vec::new());
    for (chart, j, i) in (0..2 * n).flat_map(|row| (0..n).map(move |i| (row / n, row % n, i))) {
        positions.push(whole.positions()[(j * (2 * n - 1) + chart * (n - 1) + i) as usize]);
        let next = match (chart, i) {
            (0, i) if i == n - 1 => Some(n * n + j * n),
            (1, 0) => Some(j * n + n - 1),
            _ => None,
        };
        particles.push(Particle::Free { next });
    }
    let grids = (0..2).map(|g| Grid { name: format!("{g}"), first: g * n * n, width: n, height: n }).collect();
    let Rest::Constant(rest) = whole.rest() else { panic!("a flat cloth has constants") };
    let rest = Rest::Constant(vec![rest[0]; 2]);
    let parts = Parts { name: "sewn".into(), grids, positions, particles, rest, mass: Mass::Constant(1.0) };
    let mut both = [whole, Cloth::new(parts).unwrap()];
    both.iter_mut().for_each(|c| c.set_material(&FABRIC).unwrap());
    both
}

#[test]
fn a_seam_bends_as_the_cloth_around_it() {
    let [whole, sewn] = sewn(13);
    let roll = |p: [f32; 3]| {
        let x = f64::from(p[0]);
        [0.5 * (x / 0.5).sin(), 0.5 * (x / 0.5).cos(), f64::from(p[2])]
    };
    let (a, b) = (bent(&whole, roll), bent(&sewn, roll));
    assert!(a > 1e-4 && (a / b - 1.0).abs() < 1e-5, "{a} {b}");
    assert!((whole.total_mass() / sewn.total_mass() - 1.0).abs() < 1e-6);
    // A crease along the seam costs what it costs elsewhere: as sharp as a cell is wide.
    let fold = |at: f64| move |p: [f32; 3]| [f64::from(p[0]), (f64::from(p[0]) - at).abs(), f64::from(p[2])];
    let (seam, beside) = (bent(&sewn, fold(0.5)), bent(&sewn, fold(0.25)));
    assert!((seam / beside - 1.0).abs() < 1e-4, "{seam} {beside}");
    // The bound knows both sides: it is that of the whole.
    let bounds = [&whole, &sewn].map(|c| c.bending().unwrap().bounds(c));
    assert!((bounds[0][25 * 6 + 12] / bounds[1][13 * 6 + 12] - 1.0).abs() < 1e-5);
}

#[test]
fn cells_of_three_corners_and_holes_have_an_area() {
    let flat = sheet(9, 9, 0.0);
    let mut particles = flat.particles().to_vec();
    (particles[40], particles[0]) = (Particle::None, Particle::None);
    let Rest::Image(rest) = flat.rest().clone() else { panic!("made so") };
    let (grids, positions) = (flat.grids().to_vec(), flat.positions().to_vec());
    let parts =
        Parts { name: "hole".into(), grids, positions, particles, rest: Rest::Image(rest), mass: Mass::Constant(1.0) };
    let mut cloth = Cloth::new(parts).unwrap();
    cloth.set_material(&FABRIC).unwrap();
    // Five cells are halves.
    let cell = 0.8 / 64.0;
    assert!((area(&cloth) - (0.8 - 2.5 * cell)).abs() < 1e-6, "{}", area(&cloth));
    let stretched = tension(&cloth, |p| [1.01 * f64::from(p[0]), f64::from(p[1]), 0.0]);
    assert!((stretched / (0.5 * area(&cloth) * FABRIC.weft * 1e-4) - 1.0).abs() < 1e-3);
    // No moment beside a hole; elsewhere there is.
    let compliance = &cloth.bending().unwrap().compliance;
    assert_eq!((compliance[39], compliance[31], compliance[49]), (0.0, 0.0, 0.0));
    assert!(compliance[20] > 0.0 && compliance[10] > 0.0);
}

#[test]
fn grain_that_jumps_or_says_nothing_is_not_followed() {
    let stiffness = |cloth: &Cloth| tension(cloth, |p| [1.01 * f64::from(p[0]), f64::from(p[1]), 0.0]) / area(cloth);
    let along = |k: f64| 0.5 * k * 1e-4;
    let mut cloth = sheet(9, 9, 0.0);
    cloth.set_material(&FABRIC).unwrap();
    assert!((stiffness(&cloth) / along(FABRIC.weft) - 1.0).abs() < 1e-3);
    // Turned by a right angle, v runs across the columns.
    let turned = cloth.positions().iter().map(|p| [p[1], p[0]]).collect();
    cloth.set_grain(Some(turned)).unwrap();
    cloth.set_material(&FABRIC).unwrap();
    assert!((stiffness(&cloth) / along(FABRIC.warp) - 1.0).abs() < 1e-3);
    for nothing in [None, Some(vec![[0.0; 2]; 81])] {
        cloth.set_grain(nothing).unwrap();
        cloth.set_material(&FABRIC).unwrap();
        assert!((stiffness(&cloth) / along(FABRIC.weft) - 1.0).abs() < 1e-3);
    }
    assert!(cloth.set_grain(Some(vec![[0.0; 2]; 80])).is_err());
    // One column of cells spans two panels.
    let mut jump: Vec<[f32; 2]> = cloth.positions().iter().map(|p| [p[1], p[0]]).collect();
    (0..81).filter(|k| k % 9 > 4).for_each(|k| jump[k][0] += 7.0);
    cloth.set_grain(Some(jump)).unwrap();
    cloth.set_material(&FABRIC).unwrap();
    let mixed = (7.0 * FABRIC.warp + FABRIC.weft) / 8.0;
    assert!((stiffness(&cloth) / along(mixed) - 1.0).abs() < 1e-3, "{}", stiffness(&cloth));
}

#[test]
fn numbers_out_of_range_are_refused() {
    type Spoil = fn(&mut Material, f64);
    let fields: [(&str, Spoil); 6] = [
        ("warp", |m, x| m.warp = x),
        ("weft", |m, x| m.weft = x),
        ("shear", |m, x| m.shear = x),
        ("bending", |m, x| m.bend = x),
        ("density", |m, x| m.density = x),
        ("damping", |m, x| m.damping = x),
    ];
    for (words, spoil) in fields {
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            let mut material = Material::default();
            spoil(&mut material, wrong);
            let error = Flat::square("x", 4).cloth().unwrap().set_material(&material).unwrap_err().to_string();
            assert!(error.contains(words), "{words}: {error}");
        }
    }
    Material { bend: 0.0, damping: 0.0, ..Material::default() }.check().unwrap();
    let mut without = Flat::square("x", 4).cloth().unwrap();
    let parts = Parts {
        name: "none".into(),
        grids: without.grids().to_vec(),
        positions: without.positions().to_vec(),
        particles: without.particles().to_vec(),
        rest: Rest::None,
        mass: Mass::Constant(1.0),
    };
    without = Cloth::new(parts).unwrap();
    assert!(without.set_material(&Material::default()).unwrap_err().to_string().contains("rest lengths"));
}
