//! A hanging chain of point masses, whose period is known.

/// Period \[s\] of the fundamental mode of `rows` equal masses on a length of 1 m whose first is fixed.
///
/// The squared frequencies are the eigenvalues of a tridiagonal matrix; the least one by inverse iteration.
pub fn period(rows: usize) -> f64 {
    let n = rows - 1;
    // Tension over mass and length of the link above mass k, which carries n - k masses.
    let pull = |k: usize| if k < n { (n - k) as f64 * 9.81 * n as f64 } else { 0.0 };
    let mut x = vec![1.0; n];
    let mut least = 0.0;
    for _ in 0..200 {
        let y = solve(&pull, &x);
        let norm = y.iter().map(|v| v * v).sum::<f64>().sqrt();
        least = x.iter().map(|v| v * v).sum::<f64>().sqrt() / norm;
        x = y.iter().map(|v| v / norm).collect();
    }
    std::f64::consts::TAU / least.sqrt()
}

/// The solution of K y = x by elimination; K has pull(k) + pull(k + 1) in its diagonal and -pull(k) beside it.
fn solve(pull: &impl Fn(usize) -> f64, x: &[f64]) -> Vec<f64> {
    let mut diagonal: Vec<f64> = (0..x.len()).map(|k| pull(k) + pull(k + 1)).collect();
    let mut y = x.to_vec();
    for k in 1..x.len() {
        let by = pull(k) / diagonal[k - 1];
        diagonal[k] -= by * pull(k);
        y[k] += by * y[k - 1];
    }
    for k in (0..x.len()).rev() {
        let below = if k + 1 < x.len() { pull(k + 1) * y[k + 1] } else { 0.0 };
        y[k] = (y[k] + below) / diagonal[k];
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_mass_is_a_pendulum() {
        assert!((period(2) - std::f64::consts::TAU / 9.81f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn many_masses_are_a_rope() {
        let rope = std::f64::consts::TAU * 2.0 / 2.404825557695773 / 9.81f64.sqrt();
        assert!((period(32) - 1.68170).abs() < 1e-5 && (period(256) - 1.67000).abs() < 1e-5);
        assert!((period(2048) / rope - 1.0).abs() < 1e-3);
    }
}
