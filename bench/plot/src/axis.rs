//! Logarithmic axes.

/// A logarithmic axis from a range of values to a range of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Log {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Log {
    /// An axis that holds all positive `values` with a little room, drawn from pixel `from` to pixel `to`.
    pub fn around(values: impl IntoIterator<Item = f64>, from: f64, to: f64) -> Self {
        let logs = values.into_iter().filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let (low, high) = if low <= high { (low, high) } else { (-1.0, 0.0) };
        let room = (0.06 * (high - low)).max(0.1);
        Self { low: low - room, high: high + room, from, to }
    }

    /// Where a value lies.
    pub fn at(&self, x: f64) -> f64 {
        self.from + (self.to - self.from) * (x.log10() - self.low) / (self.high - self.low)
    }

    /// The powers of ten on the axis.
    pub fn decades(&self) -> Vec<i32> {
        (self.low.ceil() as i32..=self.high.floor() as i32).collect()
    }

    /// The multiples of powers of ten between them.
    pub fn between(&self) -> Vec<f64> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = decades.flat_map(|d| (2..10).map(move |k| f64::from(k) * 10f64.powi(d)));
        all.filter(|x| (self.low..=self.high).contains(&x.log10())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_evenly_spaced_and_within_the_axis() {
        let axis = Log::around([0.05, 20.0, 0.0, f64::NAN], 0.0, 100.0);
        assert_eq!(axis.decades(), [-1, 0, 1]);
        assert!((axis.at(1.0) - axis.at(0.1) - (axis.at(10.0) - axis.at(1.0))).abs() < 1e-9);
        assert!(axis.between().iter().all(|&x| (0.0..=100.0).contains(&axis.at(x))));
        assert!(axis.at(0.05) > 0.0 && axis.at(20.0) < 100.0);
    }

    #[test]
    fn an_axis_without_values_still_draws() {
        assert!(Log::around([], 0.0, 1.0).at(0.5).is_finite());
        assert!(Log::around([3.0], 10.0, 0.0).at(3.0).is_finite());
    }
}
