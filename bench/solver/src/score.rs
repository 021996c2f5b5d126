//! The error of a run from the positions of its frames, in f64.

use gimage_runtime::Cloth;

use crate::chain;

/// The measured figures; a figure that a scene does not ask for is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Whether a position is not finite.
    pub exploded: bool,
    /// Largest |length / rest length - 1| of a structural spring.
    pub stretch_max: Option<f64>,
    /// Mean of the same.
    pub stretch_mean: Option<f64>,
    /// How much the lowest particle hangs above -1 m \[mm\].
    pub hem_mm: Option<f64>,
    /// RMS distance from the flat vertical square \[mm\].
    pub position_rms_mm: Option<f64>,
    /// RMS speed at rest \[mm/s\].
    pub rest_mm_s: Option<f64>,
    /// Energy at the end \[J\], of gravity and of springs of 1000 N/m.
    pub energy_j: Option<f64>,
    /// Deepest particle in the sphere \[mm\].
    pub penetration_mm: Option<f64>,
    /// Particles from above the sphere that end below its centre.
    pub tunnelled: Option<f64>,
    /// Period against that of the discrete chain \[%\].
    pub period_error_pct: Option<f64>,
    /// Amplitude lost in a period \[%\].
    pub amplitude_loss_pct: Option<f64>,
}

/// Frames at the end over which a hanging cloth is measured.
const LAST: u32 = 60;
const GRAVITY: f64 = 9.81;
const STIFFNESS: f64 = 1000.0;
const RADIUS: f64 = 0.3;

/// Takes the frames in as they come.
pub struct Score {
    scene: String,
    n: usize,
    frames: u32,
    mass: f64,
    start: Vec<[f64; 3]>,
    last: Vec<[f64; 3]>,
    kept: Vec<Vec<[f64; 3]>>,
    swing: Vec<f64>,
    stretch: Vec<(f64, f64)>,
    deepest: f64,
    exploded: bool,
}

impl Score {
    /// For `frames` frames of a built-in scene.
    pub fn new(scene: &str, n: u32, frames: u32, cloth: &Cloth) -> Self {
        Score {
            scene: scene.into(),
            n: n as usize,
            frames,
            mass: f64::from(cloth.mass(0)),
            start: Vec::new(),
            last: Vec::new(),
            kept: Vec::new(),
            swing: Vec::new(),
            stretch: Vec::new(),
            deepest: 0.0,
            exploded: false,
        }
    }

    /// Whether a frame is measured; frame 0 is the start.
    pub fn wants(&self, frame: u32) -> bool {
        !self.hangs() || frame + LAST >= self.frames
    }

    fn hangs(&self) -> bool {
        self.scene.starts_with("s1")
    }

    /// Takes in a frame.
    pub fn push(&mut self, frame: u32, positions: &[[f32; 4]]) {
        let p: Vec<[f64; 3]> = positions.iter().map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect();
        self.exploded |= p.as_flattened().iter().any(|x| !x.is_finite());
        if self.hangs() {
            // The frame before the first one is for its speed alone.
            if frame + LAST > self.frames {
                self.stretch.push(self.stretch(&p));
            }
            self.kept.push(p);
            return;
        }
        if self.scene == "s3" {
            let z = |j: usize| p[j * self.n..(j + 1) * self.n].iter().map(|p| p[2]).sum::<f64>() / self.n as f64;
            self.swing.push(z(self.n - 1) - z(0));
            if frame + LAST > self.frames {
                self.stretch.push(self.stretch(&p));
            }
            return;
        }
        let nearest = p.iter().map(|p| dot(*p, *p).sqrt()).fold(f64::INFINITY, f64::min);
        self.deepest = self.deepest.max(RADIUS - nearest);
        self.stretch.push(self.stretch(&p));
        if frame == 0 {
            self.start.clone_from(&p);
        }
        self.last = p;
    }

    /// Largest and mean stretch of the structural springs.
    fn stretch(&self, p: &[[f64; 3]]) -> (f64, f64) {
        let (n, h) = (self.n, 1.0 / (self.n - 1) as f64);
        let (mut most, mut sum) = (0.0, 0.0);
        for k in 0..n * n {
            let others = [(k % n + 1 < n).then_some(k + 1), (k / n + 1 < n).then_some(k + n)];
            for other in others.into_iter().flatten() {
                let s = (distance(p[k], p[other]) / h - 1.0).abs();
                (most, sum) = (f64::max(most, s), sum + s);
            }
        }
        (most, sum / (2 * n * (n - 1)) as f64)
    }

    /// The figures after the last frame.
    pub fn figures(&self) -> Figures {
        if self.exploded {
            return Figures { exploded: true, ..Figures::default() };
        }
        let count = self.stretch.len() as f64;
        let mut out = Figures {
            stretch_max: self.stretch.iter().map(|s| s.0).reduce(f64::max),
            stretch_mean: (count > 0.0).then(|| self.stretch.iter().map(|s| s.1).sum::<f64>() / count),
            ..Figures::default()
        };
        match self.scene.as_str() {
            "s1" | "s1k" => self.hanging(&mut out),
            "s3" => self.swinging(&mut out),
            _ => {
                out.penetration_mm = Some(1e3 * self.deepest);
                let above = |p: &[f64; 3]| p[0].hypot(p[2]) < 0.2;
                let through = self.start.iter().zip(&self.last).filter(|(was, is)| above(was) && is[1] < 0.0);
                out.tunnelled = Some(through.count() as f64);
            }
        }
        out
    }

    fn hanging(&self, out: &mut Figures) {
        let (n, h) = (self.n, 1.0 / (self.n - 1) as f64);
        let [_, frames @ ..] = &self.kept[..] else { return };
        let Some(end) = frames.last() else { return };
        let (left, right) = (end[0], end[n - 1]);
        let truth = |k: usize| {
            let (i, j) = ((k % n) as f64 * h, (k / n) as f64 * h);
            [i * (right[0] - left[0]) + left[0], -j, left[2]]
        };
        let mean = |f: &dyn Fn(&Vec<[f64; 3]>) -> f64| frames.iter().map(f).sum::<f64>() / frames.len() as f64;
        let lowest = |p: &Vec<[f64; 3]>| p.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        let square = |a: [f64; 3], b: [f64; 3]| distance(a, b).powi(2);
        let off = |p: &Vec<[f64; 3]>| (0..n * n).map(|k| square(p[k], truth(k))).sum::<f64>() / (n * n) as f64;
        let moved = self
            .kept
            .windows(2)
            .map(|w| w[0].iter().zip(&w[1]).map(|(a, b)| square(*a, *b)).sum::<f64>() * 3600.0 / (n * n) as f64);
        out.hem_mm = Some(1e3 * (mean(&lowest) + 1.0));
        out.position_rms_mm = Some(1e3 * mean(&off).sqrt());
        out.rest_mm_s = Some(1e3 * (moved.sum::<f64>() / frames.len() as f64).sqrt());
        if self.scene == "s1k" {
            out.energy_j = Some(self.energy(end));
        }
    }

    fn energy(&self, p: &[[f64; 3]]) -> f64 {
        let (n, h) = (self.n, 1.0 / (self.n - 1) as f64);
        let mut sum: f64 = p.iter().map(|p| self.mass * GRAVITY * p[1]).sum();
        for k in 0..n * n {
            let (right, down) = (k % n + 1 < n, k / n + 1 < n);
            let diagonal = h * std::f64::consts::SQRT_2;
            let others = [(right, k + 1, h), (down, k + n, h), (right && down, k + n + 1, diagonal)];
            let up = (k / n > 0 && right).then(|| (true, k + 1 - n, diagonal));
            for (_, other, rest) in others.into_iter().chain(up).filter(|o| o.0) {
                sum += 0.5 * STIFFNESS * (distance(p[k], p[other]) - rest).powi(2);
            }
        }
        sum
    }

    fn swinging(&self, out: &mut Figures) {
        let z = &self.swing;
        let crossings: Vec<f64> = (1..z.len())
            .filter(|k| z[k - 1] * z[*k] < 0.0)
            .map(|k| k as f64 - 1.0 + z[k - 1] / (z[k - 1] - z[k]))
            .collect();
        let a: Vec<f64> = z.iter().map(|z| z.abs()).collect();
        let peaks: Vec<f64> = (1..z.len() - 1).filter(|&k| a[k] >= a[k - 1] && a[k] > a[k + 1]).map(|k| a[k]).collect();
        if let [first, .., last] = crossings[..] {
            let period = 2.0 * (last - first) / (crossings.len() - 1) as f64 / 60.0;
            out.period_error_pct = Some(100.0 * (period / chain::period(self.n) - 1.0));
        }
        if let [first, _, .., last] = peaks[..] {
            out.amplitude_loss_pct = Some(100.0 * (1.0 - (last / first).powf(2.0 / (peaks.len() - 1) as f64)));
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [0, 1, 2].map(|c| a[c] - b[c]);
    dot(d, d).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use gimage_runtime::scene::builtin;

    fn texels(of: impl Fn(usize, usize) -> [f32; 3]) -> Vec<[f32; 4]> {
        let at = |k: usize| of(k % 5, k / 5);
        (0..25).map(at).map(|[x, y, z]| [x, y, z, 1.0]).collect()
    }

    #[test]
    fn the_flat_square_has_no_error_and_a_moved_one_has_a_speed() {
        let cloth = &builtin("s1", 5).unwrap().cloths[0];
        let mut score = Score::new("s1", 5, 600, cloth);
        assert!(!score.wants(539) && score.wants(540));
        for frame in 540..=600 {
            let z = 0.25 * frame as f32;
            score.push(frame, &texels(|i, j| [i as f32 * 0.25, -(j as f32) * 0.25, z]));
        }
        let f = score.figures();
        assert_eq!((f.stretch_max, f.stretch_mean, f.hem_mm), (Some(0.0), Some(0.0), Some(0.0)));
        assert!((f.rest_mm_s.unwrap() - 0.25 * 60.0 * 1e3).abs() < 1e-6);
        // Frames 541 to 600 against the last one's top row.
        assert!(f.position_rms_mm.unwrap() > 1e3);
    }

    #[test]
    fn a_sphere_is_entered_and_passed() {
        let cloth = &builtin("s2", 5).unwrap().cloths[0];
        let mut score = Score::new("s2", 5, 1, cloth);
        score.push(0, &texels(|i, j| [i as f32 * 0.25 - 0.5, 0.5, j as f32 * 0.25 - 0.5]));
        score.push(1, &texels(|i, j| [i as f32 * 0.25 - 0.5, -0.2, j as f32 * 0.25 - 0.5]));
        let f = score.figures();
        assert!((f.penetration_mm.unwrap() - 100.0).abs() < 1e-4);
        assert_eq!((f.tunnelled, f.exploded), (Some(1.0), false));
        score.push(2, &texels(|_, _| [f32::NAN; 3]));
        assert!(score.figures().exploded);
    }

    #[test]
    fn a_swing_has_its_period() {
        let cloth = &builtin("s3", 5).unwrap().cloths[0];
        let mut score = Score::new("s3", 5, 600, cloth);
        let turn = std::f64::consts::TAU / chain::period(5) / 60.0;
        for frame in 0..=600u32 {
            let t = f64::from(frame);
            let z = ((turn * t).cos() * 0.99f64.powf(t * turn / std::f64::consts::TAU)) as f32;
            score.push(frame, &texels(|_, j| [0.0, 0.0, z * j as f32]));
        }
        let f = score.figures();
        assert!(f.period_error_pct.unwrap().abs() < 0.01, "{f:?}");
        assert!((f.amplitude_loss_pct.unwrap() - 1.0).abs() < 0.05, "{f:?}");
    }

    #[test]
    fn energy_counts_every_spring_once() {
        let cloth = &builtin("s1k", 5).unwrap().cloths[0];
        let score = Score::new("s1k", 5, 600, cloth);
        let p: Vec<[f64; 3]> = (0..25).map(|k| [0.5 * (k % 5) as f64, 0.0, 0.5 * (k / 5) as f64]).collect();
        let (h, d) = (0.25f64, 0.25 * 2f64.sqrt());
        let truth = 0.5 * 1000.0 * (40.0 * h * h + 32.0 * d * d);
        assert!((score.energy(&p) - truth).abs() < 1e-9);
    }
}
