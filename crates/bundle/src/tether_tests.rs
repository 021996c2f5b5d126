use super::*;
use proptest::prelude::*;

/// A grid of points, what they are, and springs as long as the points are apart.
#[derive(Debug)]
struct Sheet {
    width: usize,
    positions: Vec<[f64; 3]>,
    particles: Vec<Particle>,
    rest: Vec<[f32; 4]>,
}

const STEPS: [(isize, isize); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

impl Sheet {
    fn new(width: usize, height: usize, point: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        let positions = (0..width * height)
            .map(|k| point((k % width) as f64 / (width - 1) as f64, (k / width) as f64 / (height - 1) as f64))
            .collect();
        let particles = vec![Particle::Free { next: None }; width * height];
        let mut sheet = Sheet { width, positions, particles, rest: vec![[0.0; 4]; width * height] };
        for k in 0..width * height {
            sheet.rest[k] = [0, 1, 2, 3].map(|c| sheet.end(k, c).map_or(0.0, |e| sheet.chord(k, e) as f32));
        }
        sheet
    }

    fn flat(width: usize, height: usize) -> Self {
        Sheet::new(width, height, |u, v| [u, v * (height - 1) as f64 / (width - 1) as f64, 0.0])
    }

    fn end(&self, k: usize, kind: usize) -> Option<usize> {
        let (i, j) = (k % self.width, k / self.width);
        let (i, j) = (i.checked_add_signed(STEPS[kind].0)?, j.checked_add_signed(STEPS[kind].1)?);
        (i < self.width && j < self.positions.len() / self.width).then_some(j * self.width + i)
    }

    fn chord(&self, a: usize, b: usize) -> f64 {
        (0..3).map(|c| (self.positions[a][c] - self.positions[b][c]).powi(2)).sum::<f64>().sqrt()
    }

    fn pin(mut self, pins: &[usize]) -> Self {
        for &k in pins {
            self.particles[k] = Particle::Pinned { next: self.particles[k].next() };
        }
        self
    }

    fn link(&mut self, ring: &[usize]) {
        for (n, &k) in ring.iter().enumerate() {
            self.particles[k] = Particle::Free { next: Some(ring[(n + 1) % ring.len()] as u32) };
        }
    }

    /// Cuts every spring across the line between columns `i` and `i + 1`, in the rows given.
    fn slit(mut self, i: usize, rows: std::ops::Range<usize>) -> Self {
        for k in 0..self.positions.len() {
            for kind in 0..4 {
                let Some(e) = self.end(k, kind) else { continue };
                let across = k % self.width == i && e % self.width == i + 1;
                if across && rows.contains(&(k / self.width)) && rows.contains(&(e / self.width)) {
                    self.rest[k][kind] = 0.0;
                }
            }
        }
        self
    }

    fn tethers(&self, most: usize) -> Tethers {
        let (width, height) = (self.width as u32, (self.positions.len() / self.width) as u32);
        tethers(&[SpringGrid { width, height, rest: RestLengths::Image(&self.rest) }], &self.particles, &[], most)
    }

    /// Largest and smallest relative error of the nearest anchor against `truth`, over distances above 0.
    fn error(&self, truth: impl Fn(usize) -> f64) -> (f64, f64) {
        let found = self.tethers(1);
        let errors = (0..self.positions.len()).filter(|&k| truth(k) > 0.0).map(|k| {
            assert!(found.of(k)[0].exists(), "{k}");
            f64::from(found.of(k)[0].distance) / truth(k) - 1.0
        });
        errors.fold((f64::NEG_INFINITY, f64::INFINITY), |(hi, lo), e| (hi.max(e), lo.min(e)))
    }
}

#[test]
fn a_flat_square_has_straight_lines_in_every_direction() {
    for (height, pin) in [(129, 0), (129, 129 * 40 + 77), (33, 5), (400, 128)] {
        let sheet = Sheet::flat(129, height).pin(&[pin]);
        let (hi, lo) = sheet.error(|k| sheet.chord(pin, k));
        assert!(hi < 1e-6 && lo > -1e-6, "{height} {pin}: {hi:e} {lo:e}");
    }
}

#[test]
fn stretched_texels_are_as_exact() {
    for (x, y) in [(1.0, 8.0), (5.0, 1.0), (1.0, 1.7)] {
        let sheet = Sheet::new(65, 65, |u, v| [x * u, y * v, 0.0]).pin(&[7]);
        let (hi, lo) = sheet.error(|k| sheet.chord(7, k));
        assert!(hi < 1e-6 && lo > -1e-6, "{x} x {y}: {hi:e} {lo:e}");
    }
}

#[test]
fn constant_lengths_are_the_same_as_an_image_of_them() {
    let sheet = Sheet::flat(17, 17).pin(&[3, 200]);
    let rest = RestLengths::Constant(sheet.rest[17]);
    let found = tethers(&[SpringGrid { width: 17, height: 17, rest }], &sheet.particles, &[], 2);
    for (a, b) in found.anchors.iter().zip(&sheet.tethers(2).anchors) {
        assert!(a.particle == b.particle && (a.distance - b.distance).abs() <= 1e-6 * a.distance);
    }
}

/// Two flat squares side by side of `n` x `n` texels, joined along their common column from row `tip` on.
fn halves(n: usize, tip: usize) -> Vec<Particle> {
    let mut particles = vec![Particle::Free { next: None }; 2 * n * n];
    for j in tip..n {
        let (a, b) = (j * n + n - 1, n * n + j * n);
        particles[a] = Particle::Free { next: Some(b as u32) };
        particles[b] = Particle::Free { next: Some(a as u32) };
    }
    particles
}

#[test]
fn paths_go_on_over_stitches() {
    // Two squares of one plane; the second begins at x = 0.4, between the columns and rows of the first, and is sewn there.
    for (n, thread) in [(33usize, 0.0f32), (65, 0.0), (33, 0.02)] {
        let square = Sheet::flat(n, n);
        let h = 1.0 / (n - 1) as f64;
        let [left, top] = [0.4 + 0.3 * h, 0.4 * h];
        let at = |k: usize| {
            let (sheet, k) = ((k / (n * n)) as f64, k % (n * n));
            [(k % n) as f64 * h + sheet * left, (k / n) as f64 * h + sheet * top]
        };
        let stitches: Vec<Stitch> = (0..n - 1)
            .map(|j| Stitch {
                particle: (n * n + j * n) as u32,
                piece: 0,
                at: at(n * n + j * n).map(|x| x as f32),
                distance: thread,
            })
            .collect();
        let grid = SpringGrid { width: n as u32, height: n as u32, rest: RestLengths::Image(&square.rest) };
        // A pin on either side of the stitches; a path from the second sheet to the first leads through particles.
        for (pin, to, slack) in
            [(n * (n / 2) + 3, n * n..2 * n * n, 1e-2), (n * n + n * (n / 2) + n - 2, 0..n * n, 1.5 * h)]
        {
            let mut particles = vec![Particle::Free { next: None }; 2 * n * n];
            particles[pin] = Particle::Pinned { next: None };
            assert!(to.clone().all(|k| !tethers(&[grid, grid], &particles, &[], 1).of(k)[0].exists()));
            let found = tethers(&[grid, grid], &particles, &stitches, 1);
            let (mut hi, mut lo) = (0.0f64, 0.0f64);
            for k in to {
                let (p, q) = (at(pin), at(k));
                // Where the straight way crosses the line of stitches; beyond its ends, and on the same side, it leads elsewhere.
                let share = (left - p[0]) / (q[0] - p[0]);
                let y = p[1] + share * (q[1] - p[1]);
                if (0.0..=1.0).contains(&share) && (top..top + (n - 2) as f64 * h).contains(&y) {
                    let truth = (p[0] - q[0]).hypot(p[1] - q[1]) + f64::from(thread);
                    let error = f64::from(found.of(k)[0].distance) - truth;
                    (hi, lo) = (hi.max(error), lo.min(error));
                }
            }
            assert!(hi > 0.0 && hi < slack && lo > -1e-6, "{n} {thread} {pin}: {hi:e} of {slack:e}, {lo:e}");
        }
    }
}

#[test]
fn stitches_to_quads_that_are_gone_lead_nowhere() {
    let n = 9;
    let square = Sheet::flat(n, n);
    let mut particles = vec![Particle::Free { next: None }; 2 * n * n];
    particles[0] = Particle::Pinned { next: None };
    let stitch = |particle: usize, piece| Stitch { particle: particle as u32, piece, at: [0.55; 2], distance: 0.0 };
    let reach = |particles: &[Particle], rest: &[[f32; 4]], stitch: Stitch| {
        let grid = SpringGrid { width: n as u32, height: n as u32, rest: RestLengths::Image(rest) };
        tethers(&[grid, grid], particles, &[stitch], 1).of(2 * n * n - 1)[0].exists()
    };
    assert!(reach(&particles, &square.rest, stitch(n * n, 0)));
    // To a grid that there is not, from a particle that there is not, and to a quad without a spring or without a corner.
    assert!(!reach(&particles, &square.rest, stitch(n * n, 2)));
    assert!(!reach(&particles, &square.rest, stitch(9 * n * n, 0)));
    let mut cut = square.rest.clone();
    cut[4 * n + 4][2] = 0.0;
    assert!(!reach(&particles, &cut, stitch(n * n, 0)));
    particles[5 * n + 5] = Particle::None;
    assert!(!reach(&particles, &square.rest, stitch(n * n, 0)));
}

#[test]
fn paths_go_round_the_end_of_a_slit() {
    for n in [33, 65, 129] {
        let square = Sheet::flat(n, n);
        let (tip, pin) = (n / 2, 2 * n + n / 4);
        let mut particles = halves(n, tip);
        particles[pin] = Particle::Pinned { next: None };
        let grid = SpringGrid { width: n as u32, height: n as u32, rest: RestLengths::Image(&square.rest) };
        let found = tethers(&[grid, grid], &particles, &[], 1);
        let h = 1.0 / (n - 1) as f64;
        let at = |k: usize| [(k % n + k / (n * n) * (n - 1)) as f64 * h, (k % (n * n) / n) as f64 * h];
        let far = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
        let (from, end) = (at(pin), [1.0, tip as f64 * h]);
        let (mut hi, mut lo) = (0.0f64, 0.0f64);
        for k in (0..2 * n * n).filter(|&k| k != pin) {
            let q = at(k);
            let straight =
                q[0] <= 1.0 && k < n * n || from[1] + (q[1] - from[1]) * (1.0 - from[0]) / (q[0] - from[0]) >= end[1];
            let truth = if straight { far(from, q) } else { far(from, end) + far(end, q) };
            let error = f64::from(found.of(k)[0].distance) / truth - 1.0;
            (hi, lo) = (hi.max(error), lo.min(error));
        }
        assert!(hi < 0.01 && lo > -1e-6, "{n}: {hi:e} {lo:e}");
    }
}

#[test]
fn cut_springs_are_not_crossed() {
    let n = 65;
    let (left, pin, h) = (n / 2, 2 * n + n / 4, 1.0 / (n - 1) as f64);
    let sheet = Sheet::flat(n, n).slit(left, 0..n / 2).pin(&[pin]);
    let found = sheet.tethers(1);
    let ends = [n / 2 * n + left - n, n / 2 * n + left + 1 - n];
    for k in (0..n * n / 4).filter(|k| k % n > left) {
        let least = sheet.chord(pin, ends[0]) + sheet.chord(ends[1], k);
        let length = f64::from(found.of(k)[0].distance);
        assert!(length > least && length < least + 3.0 * h, "{k}: {length} {least}");
    }
}

/// A cylinder of radius 1 / tau and height 1, closed by a seam between the first column and the last.
fn cylinder(n: usize) -> Sheet {
    let turn = std::f64::consts::TAU;
    let radius = 1.0 / turn;
    let mut sheet = Sheet::new(n, n, |u, v| {
        let (s, c) = (u * turn).sin_cos();
        [radius * c, v, radius * s]
    });
    for j in 0..n {
        sheet.link(&[j * n, j * n + n - 1]);
    }
    sheet
}

#[test]
fn distances_cross_seams() {
    for n in [33, 65, 129] {
        let pin = 5 * n + n / 8;
        let sheet = cylinder(n).pin(&[pin]);
        let at = |k: usize| ((k % n) as f64 / (n - 1) as f64, (k / n) as f64 / (n - 1) as f64);
        let (hi, lo) = sheet.error(|k| {
            let around = (at(k).0 - at(pin).0).abs();
            around.min(1.0 - around).hypot(at(k).1 - at(pin).1)
        });
        assert!(hi < 0.01 && lo > -0.01, "{n}: {hi:e} {lo:e}");
        let found = sheet.tethers(1);
        for j in 0..n {
            assert_eq!(found.of(j * n), found.of(j * n + n - 1));
        }
    }
}

#[test]
fn charts_joined_by_rings_are_one_surface() {
    // The flat square in two grids whose seam is drawn twice.
    let (w, h) = (33, 40);
    let whole = Sheet::flat(2 * w - 1, h);
    let mut particles = vec![Particle::Free { next: None }; 2 * w * h];
    for j in 0..h {
        let (a, b) = (j * w + w - 1, w * h + j * w);
        particles[a] = Particle::Free { next: Some(b as u32) };
        particles[b] = Particle::Free { next: Some(a as u32) };
    }
    particles[3 * w + 4] = Particle::Pinned { next: None };
    let rest = RestLengths::Constant(whole.rest[2 * w]);
    let grid = SpringGrid { width: w as u32, height: h as u32, rest };
    let found = tethers(&[grid, grid], &particles, &[], 1);
    for k in 0..2 * w * h {
        let (i, j) = (k % w + if k < w * h { 0 } else { w - 1 }, k % (w * h) / w);
        let truth = whole.chord(3 * (2 * w - 1) + 4, j * (2 * w - 1) + i);
        assert!((f64::from(found.of(k)[0].distance) - truth).abs() < 1e-6, "{k}");
        assert_eq!(found.of(k)[0].particle as usize, 3 * w + 4);
    }
}

#[test]
fn a_ball_is_measured_to_the_order_of_its_texels() {
    let mut last = f64::INFINITY;
    for n in [17, 33, 65] {
        // The part of a unit sphere within 60 degrees of the equator and of the prime meridian.
        let third = std::f64::consts::FRAC_PI_3;
        let sheet = Sheet::new(n, n, |u, v| {
            let (b, l) = ((2.0 * v - 1.0) * third, (2.0 * u - 1.0) * third);
            [b.cos() * l.cos(), b.sin(), b.cos() * l.sin()]
        });
        let pin = n / 2 * n + n / 2;
        let sheet = sheet.pin(&[pin]);
        let (hi, lo) = sheet.error(|k| 2.0 * (sheet.chord(pin, k) / 2.0).min(1.0).asin());
        assert!(hi < 0.01 && lo > -1.0 / (n - 1) as f64, "{n}: {hi:e} {lo:e}");
        assert!(hi.max(-lo) < 0.7 * last);
        last = hi.max(-lo);
    }
}

#[test]
fn a_pinned_row_is_one_group_and_two_corners_are_two() {
    let n = 33;
    let row: Vec<usize> = (0..n).collect();
    let sheet = Sheet::flat(n, n).pin(&row);
    let found = sheet.tethers(4);
    for k in 0..n * n {
        let [first, rest @ ..] = found.of(k) else { panic!("four slots") };
        assert_eq!(first.particle as usize, k % n);
        assert!((f64::from(first.distance) - sheet.positions[k][1]).abs() < 1e-6);
        assert_eq!(rest, [Anchor::NONE; 3]);
    }
    let sheet = Sheet::flat(n, n).pin(&[0, n - 1]);
    let found = sheet.tethers(4);
    for k in 0..n * n {
        let of = found.of(k);
        assert!(of[0].distance <= of[1].distance && of[2..] == [Anchor::NONE; 2]);
        for a in &of[..2] {
            assert!((f64::from(a.distance) - sheet.chord(a.particle as usize, k)).abs() < 1e-6);
        }
        assert_eq!([of[0].particle.min(of[1].particle), of[0].particle.max(of[1].particle)], [0, n as u32 - 1]);
    }
}

#[test]
fn many_single_pins_give_the_nearest_four() {
    let n = 49;
    let pins: Vec<usize> = (0..n * n).filter(|k| (k % n) % 8 == 0 && (k / n) % 8 == 0).collect();
    let sheet = Sheet::flat(n, n).pin(&pins);
    let found = sheet.tethers(4);
    for k in 0..n * n {
        let mut truth: Vec<f64> = pins.iter().map(|&p| sheet.chord(p, k)).collect();
        truth.sort_by(f64::total_cmp);
        for (slot, a) in found.of(k).iter().enumerate() {
            let length = f64::from(a.distance);
            assert!((length - sheet.chord(a.particle as usize, k)).abs() < 1e-6, "{k} {slot}");
            assert!((length - truth[slot]).abs() < 1e-6, "{k} {slot}: {length} {}", truth[slot]);
        }
    }
}

#[test]
fn what_cannot_be_reached_has_no_anchor() {
    let n = 9;
    let mut sheet = Sheet::flat(n, n).slit(4, 0..n).pin(&[0]);
    sheet.particles[n + 1] = Particle::None;
    let found = sheet.tethers(2);
    for k in 0..n * n {
        assert_eq!(found.of(k)[0].exists(), k % n <= 4 && k != n + 1, "{k}");
    }
    assert!(!found.is_empty() && Sheet::flat(n, n).tethers(2).is_empty());
    assert_eq!(sheet.tethers(0).anchors, []);
    assert_eq!(sheet.tethers(9).per_particle, MAX_ANCHORS);
    // Lists that are too short, and a pin without springs.
    let short = SpringGrid { width: 9, height: 9, rest: RestLengths::Image(&[]) };
    assert_eq!(tethers(&[short], &[Particle::Pinned { next: None }; 3], &[], 1).anchors.len(), 3);
    assert_eq!(tethers(&[], &sheet.particles, &[], 1).of(0), [Anchor { particle: 0, distance: 0.0 }]);
}

/// A flat sheet whose inner points are moved by up to a fifth of a texel.
fn crumpled() -> impl Strategy<Value = Sheet> {
    let n = 17;
    prop::collection::vec((-0.2..0.2f64, -0.2..0.2f64), n * n).prop_map(move |moves| {
        let cell = 1.0 / (n - 1) as f64;
        Sheet::new(n, n, |u, v| {
            let k = (v * (n - 1) as f64).round() as usize * n + (u * (n - 1) as f64).round() as usize;
            let edge = [u, v].iter().any(|x| *x == 0.0 || *x == 1.0);
            let (du, dv) = if edge { (0.0, 0.0) } else { moves[k] };
            [u + cell * du, v + cell * dv, 0.0]
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn uneven_texels_of_a_flat_sheet_are_exact_too(sheet in crumpled(), pin in 0usize..289) {
        let sheet = sheet.pin(&[pin]);
        let (hi, lo) = sheet.error(|k| sheet.chord(pin, k));
        prop_assert!(hi < 1e-5 && lo > -1e-6, "{hi:e} {lo:e}");
    }

    #[test]
    fn the_nearest_of_a_row_of_pins_is_found(sheet in crumpled(), row in 0usize..17, slope in 0usize..2) {
        let pins: Vec<usize> = (0..17).map(|i| (row + slope * i) % 17 * 17 + i).collect();
        let sheet = sheet.pin(&pins);
        let truth = |k: usize| pins.iter().map(|&p| sheet.chord(p, k)).fold(f64::INFINITY, f64::min);
        let (hi, lo) = sheet.error(truth);
        prop_assert!(hi < 0.03 && lo > -1e-6, "{hi:e} {lo:e}");
    }

    #[test]
    fn no_tether_is_shorter_than_the_chord_or_jumps_along_a_spring(
        sheet in crumpled(),
        pins in prop::collection::btree_set(0usize..289, 1..40),
        cut in 0usize..16,
        rows in 0usize..17,
        missing in 0usize..289,
    ) {
        let pins: Vec<usize> = pins.into_iter().collect();
        let mut sheet = sheet.slit(cut, 0..rows).pin(&pins);
        sheet.particles[missing] = Particle::None;
        let found = sheet.tethers(4);
        prop_assert_eq!(&found, &sheet.tethers(4));
        for k in 0..289 {
            let of = found.of(k);
            prop_assert_eq!(sheet.particles[k].is_pinned(), of[0].exists() && of[0].distance == 0.0);
            for a in of.iter().filter(|a| a.exists()) {
                prop_assert!(sheet.particles[a.particle as usize].is_pinned());
                prop_assert!(f64::from(a.distance) >= sheet.chord(a.particle as usize, k) * (1.0 - 1e-6));
            }
            for kind in 0..4 {
                let Some(e) = sheet.end(k, kind).filter(|&e| k != missing && e != missing) else { continue };
                let length = sheet.rest[k][kind];
                let other = found.of(e)[0];
                if length > 0.0 {
                    prop_assert_eq!(of[0].exists(), other.exists());
                    prop_assert!((of[0].distance - other.distance).abs() <= length * (1.0 + 1e-5));
                }
            }
        }
    }

    #[test]
    fn a_mirrored_sheet_has_mirrored_tethers(
        sheet in crumpled(),
        pins in prop::collection::btree_set(0usize..289, 1..12),
    ) {
        // Turning the grid by half a turn changes the order of everything but not the surface.
        let pins: Vec<usize> = pins.into_iter().collect();
        let turned_pins: Vec<usize> = pins.iter().rev().map(|p| 288 - p).collect();
        let at = |u: f64, v: f64| 288 - ((v * 16.0).round() as usize * 17 + (u * 16.0).round() as usize);
        let turned = Sheet::new(17, 17, |u, v| sheet.positions[at(u, v)]).pin(&turned_pins);
        let (a, b) = (sheet.pin(&pins).tethers(4), turned.tethers(4));
        for k in 0..289 {
            for (x, y) in a.of(k).iter().zip(b.of(288 - k)) {
                prop_assert!(x.exists() == y.exists() && (x.distance - y.distance).abs() < 1e-6 );
            }
        }
    }
}
