use super::*;
use crate::choose::Settings;
use crate::cloth::{Bridges, Cloth, Flat, Grid, Mass, Particle, Parts, Rest, Tethers};
use crate::cpu::body::Body;
use crate::cpu::rows::Threads;
use crate::options::Options;
use crate::scene::Scene;
use gimage_bundle::{RestLengths, SpringGrid, Stitch};

/// xorshift32.
struct Noise(u32);

impl Noise {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as usize % end
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }

    fn stroke(&mut self) -> [[f32; 2]; 2] {
        [0; 2].map(|_| [self.unit(), self.unit()].map(|x| 1.2 * x - 0.1))
    }
}

/// The cutting triangle that meets the plane of the sheets, x and z, from one point to another.
fn stroke([p, q]: [[f32; 2]; 2]) -> [[f32; 3]; 3] {
    let [mx, mz] = [0, 1].map(|c| 0.5 * (p[c] + q[c]));
    [[mx, 1.0, mz], [2.0 * p[0] - mx, -1.0, 2.0 * p[1] - mz], [2.0 * q[0] - mx, -1.0, 2.0 * q[1] - mz]]
}

/// A square of two sheets sewn along x = 0.5, of `n` rows each.
fn sewn(n: usize) -> Cloth {
    let (dx, dz) = (0.5 / (n - 1) as f32, 1.0 / (n - 1) as f32);
    let (mut positions, mut particles) = (Vec::new(), Vec::new());
    for k in 0..2 * n * n {
        let (chart, i, j) = (k / (n * n), k % n, k % (n * n) / n);
        positions.push([(chart * (n - 1) + i) as f32 * dx, 0.0, j as f32 * dz]);
        let next = match (chart, i) {
            (0, i) if i == n - 1 => Some((n * n + j * n) as u32),
            (1, 0) => Some((j * n + n - 1) as u32),
            _ => None,
        };
        particles.push(Particle::Free { next });
    }
    let rest = Rest::Constant(vec![[dx, dz, dx.hypot(dz), dx.hypot(dz)]; 2]);
    let grid = |g: usize| Grid { name: g.to_string(), first: (g * n * n) as u32, width: n as u32, height: n as u32 };
    let grids = vec![grid(0), grid(1)];
    Cloth::new(Parts { name: "sewn".into(), grids, positions, particles, rest, mass: Mass::Constant(1e-3) }).unwrap()
}

/// A square of two sheets, the second half a texel over the first and sewn to it every `each` rows by threads of 1 mm.
fn stitched(n: usize, each: usize) -> Cloth {
    let d = 1.0 / (n - 1) as f32;
    let (mut positions, mut stitches) = (Vec::new(), Vec::new());
    let left = 1.0 - 1.5 * d;
    for k in 0..2 * n * n {
        let (sheet, i, j) = ((k / (n * n)) as f32, k % n, k % (n * n) / n);
        let [x, z] = [0.5 * (i as f32 * d + sheet * left), j as f32 * d];
        positions.push([x, 1e-3 * sheet, z]);
        if sheet == 1.0 && i == 0 && j % each == 0 {
            stitches.push(Stitch { particle: k as u32, piece: 0, at: [left, z], distance: 1e-3 });
        }
    }
    let rest = Rest::Constant(vec![[0.5 * d, d, (0.5 * d).hypot(d), (0.5 * d).hypot(d)]; 2]);
    let grid = |g: usize| Grid { name: g.to_string(), first: (g * n * n) as u32, width: n as u32, height: n as u32 };
    let (particles, grids) = (vec![Particle::Free { next: None }; 2 * n * n], vec![grid(0), grid(1)]);
    let parts = Parts { name: "stitched".into(), grids, positions, particles, rest, mass: Mass::Constant(1e-3) };
    let mut cloth = Cloth::new(parts).unwrap();
    cloth.set_stitches(stitches).unwrap();
    cloth
}

fn opened(cloth: &Cloth, tethers: &Tethers) -> Body<f32> {
    let mut cloth = cloth.clone();
    let settings = Settings::new(Options::default(), &Scene::new("empty")).0;
    let mut body = Body::new(&cloth, tethers, &settings, settings.step);
    cloth.open();
    body.open(&cloth, tethers);
    body
}

fn held(body: &Body<f32>) -> &Held<f32> {
    body.held.as_ref().unwrap()
}

/// Distances along what is left from one pin: exact ones, and those along springs alone, found without any order.
fn truth(cloth: &Cloth, body: &Body<f32>, pin: usize) -> (Vec<f64>, Vec<f64>) {
    let mut alone = cloth.clone();
    (0..cloth.len()).for_each(|k| alone.set_pinned(k, false).unwrap());
    alone.set_pinned(pin, true).unwrap();
    let rest = |g: &Grid| RestLengths::Image(&body.image[g.range()]);
    let grids: Vec<_> =
        cloth.grids().iter().map(|g| SpringGrid { width: g.width, height: g.height, rest: rest(g) }).collect();
    let found = gimage_bundle::tethers(&grids, alone.particles(), cloth.stitches(), 1);
    let exact = found.anchors.iter().map(|a| if a.exists() { f64::from(a.distance) } else { f64::INFINITY }).collect();
    let (points, mut far) = (cloth.points(), vec![f64::INFINITY; cloth.len()]);
    far[points[pin] as usize] = 0.0;
    let mut springs = Vec::new();
    for (g, grid) in cloth.grids().iter().enumerate() {
        for (k, d) in (0..grid.texels()).flat_map(|k| [0, 1, 2, 3].map(|d| (k, d))) {
            let length = body.image[grid.range()][k][d];
            // An up-right spring begins here too.
            if let (Some(other), true) = (cloth.neighbour(g, k, d), length > 0.0) {
                springs.push((points[grid.first as usize + k] as usize, points[other] as usize, f64::from(length)));
            }
        }
    }
    let bridges = Bridges::of(cloth);
    for k in 0..cloth.len() {
        let whole = |quad: u32| body.image[quad as usize][2] > 0.0;
        let there = bridges.at(k).iter().filter(|(.., quad)| whole(*quad));
        springs
            .extend(there.map(|(n, length, _)| (points[k] as usize, points[*n as usize] as usize, f64::from(*length))));
    }
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for (a, b, l) in &springs {
            for (a, b) in [(*a, *b), (*b, *a)] {
                if far[a] + l < far[b] {
                    (far[b], changed) = (far[a] + l, true);
                }
            }
        }
    }
    (exact, points.iter().map(|p| far[*p as usize]).collect())
}

/// Conditions on every tether after any cut: its length is at least that of the path to its pin and at most that of the shortest
/// path along springs to any pin of its group; it exists if such a path does; duplicates have equal tethers.
fn is_true(cloth: &Cloth, body: &Body<f32>, name: &str) -> usize {
    let held = held(body);
    let mut pins: Vec<(u32, u32)> = held.anchors.iter().copied().zip(held.groups.iter().copied()).collect();
    pins.extend((0..cloth.len()).filter(|k| cloth.particles()[*k].is_pinned()).flat_map(|k| {
        let slots = k * held.slots..(k + 1) * held.slots;
        slots.filter(|t| held.most[*t] == 0.0).map(|t| (held.anchors[t], held.groups[t])).collect::<Vec<_>>()
    }));
    pins.retain(|(pin, _)| *pin != u32::MAX);
    pins.sort_unstable();
    pins.dedup();
    let ways: Vec<_> = pins.iter().map(|(pin, _)| truth(cloth, body, *pin as usize)).collect();
    // Where a particle has room for all groups, any way leads on to the same ones.
    let count = held.groups.iter().filter(|g| **g != u32::MAX).max().map_or(0, |g| *g as usize + 1);
    let all_groups = count <= held.slots;
    let mut ended = 0;
    for (t, most) in held.most.iter().enumerate().filter(|(t, _)| held.anchors[*t] != u32::MAX) {
        let (k, most) = (t / held.slots, f64::from(*most));
        let group = pins.iter().zip(&ways).filter(|((_, group), _)| *group == held.groups[t]);
        let along = group.clone().map(|(_, way)| way.1[k]).fold(f64::INFINITY, f64::min);
        held.ring(k, |m| {
            let same = m * held.slots + t % held.slots;
            assert_eq!((held.most[same], held.anchors[same]), (held.most[t], held.anchors[t]), "{name}: {k} and {m}");
        });
        if most >= f64::from(f32::MAX) {
            ended += 1;
            assert!(!all_groups || along.is_infinite(), "{name}: {k} has no tether, and a way of {along}");
            continue;
        }
        let own = group.clone().find(|((pin, _), _)| *pin == held.anchors[t]).unwrap().1;
        // Behind the ends of cuts the exact way comes out up to 0.5 % long; behind stitches with gaps, where waves through two of them are
        // taken for one, the order of the waves makes more.
        let slack = if cloth.stitches().is_empty() { 5e-3 } else { 3e-2 };
        assert!(most >= own.0[k] * (1.0 - slack), "{name}: {k} may be {most}, and is {} away", own.0[k]);
        assert!(!all_groups || most <= along * (1.0 + 1e-5), "{name}: {k} may be {most}, along springs {along}");
    }
    ended
}

#[test]
fn random_cuts_leave_tethers_true() {
    let mut noise = Noise(11);
    let (mut ended, mut grown, mut kept) = (0, 0, 0);
    for case in 0..320 {
        let n = 4 + noise.below(10);
        let mut cloth = if case % 4 == 3 {
            stitched(n, 1 + case % 3)
        } else if case % 3 == 2 {
            sewn(n)
        } else {
            Flat { width: (4 + noise.below(12)) as u32, ..Flat::square("flat", n as u32) }.cloth().unwrap()
        };
        for _ in 0..1 + noise.below(3) {
            let pin = noise.below(cloth.len());
            // Alone, or the first of a row or a diagonal.
            let (width, count) = (cloth.grids()[0].width as usize, cloth.len());
            for k in (0..1 + case % 5).map(|k| pin + k * [1, width + 1][case % 2]).filter(|k| *k < count) {
                cloth.set_pinned(k, true).unwrap();
            }
        }
        let few = case % 4 == 1;
        let tethers = cloth.tethers(if few { 1 } else { 4 });
        let mut body = opened(&cloth, &tethers);
        assert_eq!(is_true(&cloth, &body, "uncut"), 0);
        for cut in 0..4 {
            let before = held(&body).most.clone();
            body.cut(&Threads::one(), stroke(noise.stroke()));
            ended = ended.max(is_true(&cloth, &body, &format!("case {case}, cut {cut}")));
            let after = &held(&body).most;
            for (b, a) in before.iter().zip(after).filter(|(b, _)| **b < f32::MAX && **b > 0.0) {
                (grown, kept) = (grown + u32::from(a > b), kept + u32::from(a == b));
            }
        }
    }
    assert!(ended > 5 && grown > 1_000 && kept > 10_000, "{ended} {grown} {kept}");
}

#[test]
fn a_far_corner_that_is_cut_off_changes_nothing_else() {
    let mut cloth = Flat::square("flat", 33).cloth().unwrap();
    [0, 32].iter().for_each(|k| cloth.set_pinned(*k, true).unwrap());
    let tethers = cloth.tethers(2);
    let mut body = opened(&cloth, &tethers);
    body.cut(&Threads::one(), stroke([[0.7, 1.1], [1.1, 0.7]]));
    for (t, a) in tethers.anchors.iter().enumerate() {
        let (k, most) = (t / 2, held(&body).most[t]);
        // The stroke is where column and row add up to 57.6: quads from 56 to 58 may be gone.
        let sum = k % 33 + k / 33;
        if sum >= 59 {
            assert_eq!(most, f32::MAX, "{k}");
        } else if sum <= 56 {
            assert_eq!((most, held(&body).anchors[t]), (a.distance, a.particle), "{k}");
        }
    }
}

#[test]
fn a_slit_under_a_pin_is_gone_around() {
    // A pin in the middle of the first row, and a slit below it as wide as a third.
    let mut cloth = Flat::square("flat", 49).cloth().unwrap();
    cloth.set_pinned(24, true).unwrap();
    let mut body = opened(&cloth, &cloth.tethers(1));
    body.cut(&Threads::one(), stroke([[0.34, 0.26], [0.66, 0.26]]));
    let (exact, _) = truth(&cloth, &body, 24);
    let mut grown = 0;
    for (k, way) in exact.iter().enumerate().filter(|(k, _)| *k != 24) {
        let (most, straight) = (f64::from(held(&body).most[k]), (k as f64 % 49.0 - 24.0).hypot((k / 49) as f64) / 48.0);
        assert!((0.9999..1.01).contains(&(most / way)), "{k}: {most} for {way}");
        grown += usize::from(most > 1.02 * straight);
    }
    assert!(grown > 300, "{grown}");
    let at = |i: usize, j: usize| held(&body).most[49 * j + i];
    for (i, j) in [(24usize, 11usize), (0, 20), (48, 20), (0, 0)] {
        let straight = (i as f32 - 24.0).hypot(j as f32) / 48.0;
        assert!((at(i, j) - straight).abs() < 1e-6, "{i} {j}");
    }
}

#[test]
fn a_slit_under_a_pinned_row_hands_over_to_other_pins() {
    let mut cloth = Flat::square("flat", 33).cloth().unwrap();
    (0..33).for_each(|k| cloth.set_pinned(k, true).unwrap());
    let mut body = opened(&cloth, &cloth.tethers(1));
    body.cut(&Threads::one(), stroke([[0.3, 0.265], [0.7, 0.265]]));
    let held = held(&body);
    let middle = 33 * 20 + 16;
    // It hung on the pin above, and now on one beside the slit.
    assert!(held.most[middle] > 20.0 / 32.0 * 1.05 && held.most[middle] < 20.0 / 32.0 * 1.5, "{}", held.most[middle]);
    assert!(held.anchors[middle] < 11 || held.anchors[middle] > 21, "{}", held.anchors[middle]);
    for (k, most) in held.most.iter().enumerate().filter(|(k, _)| *k % 33 < 5 || k / 33 < 8) {
        assert_eq!((held.anchors[k] as usize, *most), (k % 33, (k / 33) as f32 / 32.0), "{k}");
    }
}

#[test]
fn a_piece_hangs_over_its_stitches_until_the_last_is_cut() {
    let n = 17;
    let mut cloth = stitched(n, 1);
    cloth.set_pinned(0, true).unwrap();
    let tethers = cloth.tethers(1);
    let second = n * n..2 * n * n;
    assert!(second.clone().all(|k| tethers.of(k)[0].exists()));
    let mut body = opened(&cloth, &tethers);
    let reach = |body: &Body<f32>| second.clone().filter(|k| held(body).most[*k] < f32::MAX).count();
    // A corner far from the stitches changes no tether of the second piece; a cut beside them, above the last rows, makes paths longer.
    body.cut(&Threads::one(), stroke([[0.1, 1.1], [-0.1, 0.9]]));
    assert_eq!(reach(&body), n * n);
    let before = held(&body).most[2 * n * n - n];
    body.cut(&Threads::one(), stroke([[0.44, -0.1], [0.44, 0.8]]));
    assert_eq!((is_true(&cloth, &body, "half"), reach(&body)), (1, n * n));
    assert!(held(&body).most[n * n] > before, "{} {before}", held(&body).most[n * n]);
    body.cut(&Threads::one(), stroke([[0.44, 0.7], [0.44, 1.1]]));
    is_true(&cloth, &body, "right through");
    assert_eq!(reach(&body), 0);
}

#[test]
fn what_is_cut_off_has_no_tether_and_seams_are_crossed() {
    let mut cloth = sewn(17);
    cloth.set_pinned(0, true).unwrap();
    let mut body = opened(&cloth, &cloth.tethers(1));
    // Through the seam, from the first sheet into the second.
    body.cut(&Threads::one(), stroke([[0.3, 0.47], [0.7, 0.47]]));
    assert_eq!(is_true(&cloth, &body, "half way"), 0);
    body.cut(&Threads::one(), stroke([[-0.1, 0.47], [0.35, 0.47]]));
    assert_eq!(is_true(&cloth, &body, "from the left"), 0);
    let below = |k: usize| k % 289 / 17 > 7;
    let reach = |body: &Body<f32>| (0..578).filter(|k| below(*k) && held(body).most[*k] < f32::MAX).count();
    assert_eq!(reach(&body), 2 * 17 * 9);
    body.cut(&Threads::one(), stroke([[0.65, 0.47], [1.1, 0.47]]));
    assert_eq!(is_true(&cloth, &body, "right through"), 2 * 17 * 9);
    assert_eq!(reach(&body), 0);
}
