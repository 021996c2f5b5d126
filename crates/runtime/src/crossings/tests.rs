use super::exact::{Facet, Meeting, meet};
use super::*;
use crate::cloth::{Flat, Grid, Mass, Particle, Parts, Rest};

/// Random numbers from 0 to 1, the same in every run.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }
}

/// Every pair that crosses or touches, by trying all pairs.
fn brute_force(cloths: &[Drawn]) -> [u64; 3] {
    let mesh = Mesh::new(cloths).unwrap();
    let mut counts = [0; 3];
    for a in 0..mesh.len() as u32 {
        for b in a + 1..mesh.len() as u32 {
            match meet(&mesh.facet(a), &mesh.facet(b)) {
                Meeting::Apart | Meeting::Double => {}
                Meeting::Touching => counts[2] += 1,
                Meeting::Crossing => counts[usize::from(mesh.cloth(a) != mesh.cloth(b))] += 1,
            }
        }
    }
    counts
}

fn counts(found: &Crossings) -> [u64; 3] {
    [found.within, found.between, found.touching]
}

fn all(cloths: &[Drawn]) -> Crossings {
    find(cloths, usize::MAX).unwrap()
}

/// Positions of a grid by column and row.
fn placed(width: u32, height: u32, at: impl Fn(f32, f32) -> [f32; 3]) -> Vec<[f32; 4]> {
    let texel = |k: u32| at((k % width) as f32, (k / width) as f32);
    (0..width * height).map(texel).map(|[x, y, z]| [x, y, z, 0.0]).collect()
}

fn sheet(width: u32, height: u32) -> Cloth {
    Flat { width, height, ..Flat::square("sheet", 2) }.cloth().unwrap()
}

#[test]
fn a_flat_sheet_has_none() {
    let cloth = sheet(33, 17);
    let found = all(&[Drawn::new(&cloth)]);
    assert_eq!((found.triangles, counts(&found)), (2 * 32 * 16, [0; 3]));
    assert_eq!(found, Crossings { triangles: 1024, ..Crossings::default() });
    // Whatever plane it lies in.
    let tilted = placed(33, 17, |i, j| [0.1 * i + 0.3 * j, 0.7 * i - 0.2 * j, 0.01 * i + 0.033 * j]);
    assert_eq!(counts(&all(&[Drawn::at(&cloth, &tilted)])), [0; 3]);
}

/// A strip whose cross-section crosses itself once: per row of quads two quads cross on a line, which their diagonals part at
/// different places, so that three pairs of triangles have a part of it in common.
#[test]
fn a_sheet_folded_through_itself_has_the_counted_number() {
    let section = [[0.0, 0.0], [3.0, 1.0], [3.0, 2.0], [1.0, -1.0]];
    for rows in [1, 2, 7] {
        let cloth = sheet(4, rows + 1);
        let now = placed(4, rows + 1, |i, j| [section[i as usize][0], section[i as usize][1], j]);
        let found = all(&[Drawn::at(&cloth, &now)]);
        // Triangles of neighbouring rows meet at the ends of the line.
        assert_eq!((found.within, found.between), (3 * u64::from(rows), 0), "{found:?}");
        assert_eq!(counts(&found), brute_force(&[Drawn::at(&cloth, &now)]));
        let quads: Vec<_> = found.worst.iter().map(|c| (c.first.texel[0], c.second.texel[0])).collect();
        assert!(quads.iter().all(|q| *q == (0, 2)), "{quads:?}");
        assert!(found.deepest > 0.1 && found.deepest == found.worst[0].depth, "{found:?}");
    }
}

#[test]
fn a_sheet_folded_flat_crosses_itself() {
    let cloth = sheet(5, 2);
    let now = placed(5, 2, |i, j| [if i > 2.0 { 4.0 - i } else { i }, 0.0, j]);
    let found = all(&[Drawn::at(&cloth, &now)]);
    assert_eq!(counts(&found), brute_force(&[Drawn::at(&cloth, &now)]));
    // Two quads on two: a triangle of one has a part in common with both of the other, whose diagonal is the other one.
    assert_eq!((found.within, found.deepest), (8, 0.0));
    // Folded back, but not all the way.
    let now = placed(5, 2, |i, j| if i > 2.0 { [4.0 - i, (i - 2.0) * 1e-6, j] } else { [i, 0.0, j] });
    assert_eq!(counts(&all(&[Drawn::at(&cloth, &now)])), [0; 3]);
}

/// A grid of particles at these positions; `next` is the next duplicate of a seam point.
fn sewn(now: &[[f32; 4]], [width, height]: [u32; 2], next: impl Fn(u32) -> Option<u32>) -> Cloth {
    Cloth::new(Parts {
        name: "sewn".into(),
        grids: vec![Grid { name: "sewn".into(), first: 0, width, height }],
        positions: now.iter().map(|p| [p[0], p[1], p[2]]).collect(),
        particles: (0..width * height).map(|k| Particle::Free { next: next(k) }).collect(),
        rest: Rest::None,
        mass: Mass::Constant(1.0),
    })
    .unwrap()
}

/// A tube of `n` quads around, whose last column of texels is the first again.
fn tube(n: u32) -> (Cloth, Vec<[f32; 4]>) {
    let (width, height) = (n + 1, 4);
    let angle = |i: f32| std::f32::consts::TAU * (i % n as f32) / n as f32;
    let now = placed(width, height, |i, j| [angle(i).cos(), j, angle(i).sin()]);
    let next = |k: u32| match k % width {
        0 => Some(k + n),
        c if c == n => Some(k - n),
        _ => None,
    };
    (sewn(&now, [width, height], next), now)
}

/// A seam goes round a corner of the image: the two edges there are sewn to those of the opposite corner, and the point between them has two quads.
#[test]
fn triangles_of_the_same_three_points_do_not_cross() {
    let (width, height) = (4, 3);
    // Texels (2, 0), (3, 0), (3, 1) and (0, 1), (0, 2), (1, 2) are the same points; of the corner quads the diagonals that cut these corners off are shorter.
    let pairs = [(2, 4), (3, 8), (7, 9)];
    let next = |k: u32| pairs.iter().find_map(|&(a, b)| [(a, b), (b, a)].iter().find(|p| p.0 == k).map(|p| p.1));
    let mut now = placed(width, height, |i, j| [i, if i < 2.0 { 1.0 } else { 0.0 }, j]);
    for (k, p) in [(2, [2.0, 0.0, 0.5]), (3, [2.5, 0.4, 0.0]), (7, [2.5, 0.0, 0.9])] {
        now[k] = [p[0], p[1], p[2], 0.0];
    }
    pairs.iter().for_each(|&(a, b)| now[b as usize] = now[a as usize]);
    let cloth = sewn(&now, [width, height], next);
    let drawn = [Drawn::new(&cloth)];
    let found = all(&drawn);
    assert_eq!((found.double, counts(&found)), (1, brute_force(&drawn)), "{found:?}");
    let doubled = found.worst.iter().filter(|c| (c.first.texel, c.second.texel) == ([2, 0], [0, 1]));
    assert_eq!(doubled.count(), 0, "{found:?}");
}

#[test]
fn a_tube_closed_by_a_seam_has_none() {
    for n in [3, 4, 16] {
        let (tube, mut now) = tube(n);
        assert_eq!(counts(&all(&[Drawn::new(&tube)])), [0; 3], "{n}");
        // The duplicate of the lowest index counts.
        now[n as usize] = [9.0; 4];
        assert_eq!(all(&[Drawn::at(&tube, &now)]), all(&[Drawn::new(&tube)]));
    }
    // Without the seam, the two edges touch.
    let (_, now) = tube(16);
    let open = sheet(17, 4);
    let found = all(&[Drawn::at(&open, &now)]);
    assert!(found.total() == 0 && found.touching > 0, "{found:?}");
    // A tube of two quads around is folded flat: each triangle lies on those of the other side.
    let (_, now) = tube(2);
    let found = all(&[Drawn::at(&tube(2).0, &now)]);
    assert!(found.within > 0 && found.deepest < 1e-6, "{found:?}");
}

#[test]
fn cut_triangles_are_left_out() {
    let cloth = sheet(4, 2);
    let now = placed(4, 2, |i, j| {
        [[0.0, 0.0], [3.0, 1.0], [3.0, 2.0], [1.0, -1.0]].map(|[x, y]: [f32; 2]| [x, y, j])[i as usize]
    });
    let mut holes = vec![0; 8];
    holes[2] = 3;
    let drawn = Drawn { holes: Some(&holes), ..Drawn::at(&cloth, &now) };
    assert_eq!((all(&[drawn]).triangles, all(&[drawn]).within), (4, 0));
    assert_eq!(all(&[Drawn::at(&cloth, &now)]).within, 3);
}

#[test]
fn soups_have_the_pairs_of_brute_force() {
    let mut random = Random::new(7);
    for round in 0..12 {
        let (n, m) = (8 + round, 6);
        let (a, b) = (sheet(n, m), sheet(m, n));
        // Every other soup lies on few points, so that corners, edges and planes coincide.
        let coarse = round % 2 == 0;
        let mut soup = |count: u32| -> Vec<[f32; 4]> {
            let mut number = || if coarse { (4.0 * random.next()).floor() as f32 } else { random.next() as f32 };
            (0..count).map(|_| [number(), number(), number(), 0.0]).collect()
        };
        let (p, q) = (soup(n * m), soup(n * m));
        let cloths = [Drawn::at(&a, &p), Drawn::at(&b, &q)];
        let found = all(&cloths);
        assert_eq!(counts(&found), brute_force(&cloths), "{round}");
        assert!(found.within > 0 && found.between > 0);
        assert_eq!(found.worst.len() as u64, found.total());
        let few = find(&cloths, 5).unwrap();
        assert_eq!(few, Crossings { worst: found.worst[..5].to_vec(), ..found.clone() });
        assert!(found.worst.windows(2).all(|w| w[0].depth >= w[1].depth));
        assert_eq!(few.deepest, few.worst[0].depth);
    }
}

#[test]
fn wavy_sheets_in_layers_have_the_pairs_of_brute_force() {
    let mut random = Random::new(3);
    let cloth = sheet(24, 24);
    for amount in [0.0, 0.2, 0.6, 1.2] {
        let mut layer = |height: f64| {
            let (a, b) = (random.next() as f32, random.next() as f32);
            placed(24, 24, |i, j| [i, height as f32 + amount * (a * i + b * j).sin(), j + 0.3 * (0.2 * i).sin()])
        };
        let (p, q) = (layer(0.0), layer(0.5));
        let cloths = [Drawn::at(&cloth, &p), Drawn::at(&cloth, &q)];
        let found = all(&cloths);
        assert_eq!(counts(&found), brute_force(&cloths), "{amount}");
        assert_eq!(found.between > 0, amount > 0.5, "{amount}: {found:?}");
        assert_eq!(found.within, 0);
    }
}

#[test]
#[cfg(feature = "threads")]
fn the_result_does_not_depend_on_threads() {
    let mut random = Random::new(11);
    let cloth = sheet(48, 48);
    let now: Vec<[f32; 4]> = (0..48 * 48)
        .map(|k| [(k % 48) as f32, (k / 48) as f32, 0.0, 0.0].map(|x| x + 4.0 * random.next() as f32))
        .collect();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| find(&[Drawn::at(&cloth, &now), Drawn::new(&cloth)], 50).unwrap())
    };
    let one = run(1);
    assert!(one.within > 1000, "{one:?}");
    assert_eq!([run(2), run(5)], [one.clone(), one]);
}

#[test]
fn positions_that_are_not_finite_are_counted() {
    let cloth = sheet(4, 4);
    let mut now = placed(4, 4, |i, j| [i, 0.0, j]);
    now[5][1] = f32::NAN;
    now[15][0] = f32::INFINITY;
    let found = all(&[Drawn::at(&cloth, &now)]);
    // Six triangles around an inner particle, two at the last corner.
    assert_eq!((found.not_finite, found.triangles, counts(&found)), (2, 18 - 8, [0; 3]));
    let nothing = all(&[Drawn::at(&cloth, &[[f32::NAN; 4]; 16])]);
    assert_eq!((nothing.not_finite, nothing.triangles), (16, 0));
    let point = all(&[Drawn::at(&cloth, &[[0.5; 4]; 16])]);
    assert_eq!((point.triangles, point.degenerate, counts(&point)), (0, 18, [0; 3]));
    assert_eq!(all(&[]), Crossings::default());
}

#[test]
fn lists_of_the_wrong_length_are_errors() {
    let cloth = sheet(4, 4);
    let error = find(&[Drawn::at(&cloth, &[[0.0; 4]; 15])], 1).unwrap_err().to_string();
    assert!(error.contains("15 positions for 16 particles"), "{error}");
    let drawn = Drawn { holes: Some(&[]), ..Drawn::new(&cloth) };
    assert!(find(&[drawn], 1).unwrap_err().to_string().contains("0 holes"));
}

#[test]
fn triangles_are_named_by_cloth_grid_and_texel() {
    let (a, _) = tube(8);
    let pierced =
        Flat { origin: [0.5, 0.1, -0.05], right: [1.0, 0.0, 0.0], down: [0.0, 0.3, 0.2], ..Flat::square("patch", 2) };
    let b = pierced.cloth().unwrap();
    let found = all(&[Drawn::new(&a), Drawn::new(&a), Drawn::new(&b)]);
    let pairs = found.worst.iter().filter(|c| c.second.cloth == 2);
    for c in pairs {
        let column = c.first.texel[0];
        assert!(c.first.cloth < 2 && (column == 0 || column == 7) && c.first.texel[1] == 0, "{c:?}");
        assert!(c.second.texel == [0, 0] && c.second.triangle < 2 && c.first < c.second);
    }
    let count = |cloth| found.worst.iter().filter(|c| (c.first.cloth, c.second.cloth) == (cloth, 2)).count();
    assert!(count(0) > 0 && count(0) == count(1), "{found:?}");
    // A copy in the same place lies on its twin: each triangle on one, and touches the neighbours.
    let twins = found.worst.iter().filter(|c| c.second.cloth == 1).count();
    assert_eq!((twins, found.within), (48, 0));
}

/// A triangle of three corners, which are named in order from `first`.
pub fn facet(corners: [[f32; 3]; 3], first: u32) -> Facet {
    Facet { corners: corners.map(|p| p.map(f64::from)), names: [first, first + 1, first + 2] }
}
