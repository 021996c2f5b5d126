//! The timed runs of one job, summed up.

use crate::clock::Cost;
use crate::one::Run;
use crate::row::Values;

/// The middle one, or the mean of the two in the middle; not a number without any.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut v: Vec<f64> = values.into_iter().collect();
    v.sort_unstable_by(f64::total_cmp);
    match v.len() {
        0 => f64::NAN,
        n => 0.5 * (v[(n - 1) / 2] + v[n / 2]),
    }
}

/// The smallest; not a number without any.
pub fn least(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NAN, f64::min)
}

/// Minima and medians of the runs. Memory is the median too: the largest would grow with the number of runs.
pub fn summary(runs: &[Run], triangles: usize) -> Values {
    let mut out = Values::new();
    let mut put = |name: String, x: f64| out.extend([(name, x)]);
    put("repeats".into(), runs.len() as f64);
    put("triangles".into(), triangles as f64);
    let cpu = || runs.iter().filter_map(|r| r.cpu);
    put("cpu_s_min".into(), least(cpu()));
    put("cpu_s_median".into(), median(cpu()));
    put("wall_s_min".into(), least(runs.iter().map(|r| r.wall)));
    put("wall_s_median".into(), median(runs.iter().map(|r| r.wall)));
    for Cost { stage, .. } in runs.first().map_or(&[][..], |r| &r.stages) {
        let of = |part: fn(&Cost) -> f64| {
            median(runs.iter().flat_map(|r| &r.stages).filter(|c| c.stage == *stage).map(part))
        };
        put(format!("{stage}_wall_s"), of(|c| c.wall));
        put(format!("{stage}_cpu_s"), of(|c| c.cpu));
    }
    let peak = median(runs.iter().filter_map(|r| r.peak_bytes).map(|b| b as f64));
    put("peak_mib".into(), peak / f64::from(1 << 20));
    put("bytes_per_triangle".into(), peak / triangles.max(1) as f64);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median([4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median([]).is_nan() && least([]).is_nan());
        assert_eq!(least([2.0, 1.0]), 1.0);
    }

    #[test]
    fn stages_are_summed_up_by_name() {
        let run = |wall: f64| Run {
            stages: vec![Cost { stage: "maps".into(), wall, cpu: 2.0 * wall }],
            wall,
            cpu: Some(2.0 * wall),
            peak_bytes: Some(2 << 20),
        };
        let v = summary(&[run(1.0), run(5.0), run(3.0)], 1024);
        assert_eq!((v["maps_wall_s"], v["maps_cpu_s"], v["cpu_s_min"], v["repeats"]), (3.0, 6.0, 2.0, 3.0));
        assert_eq!((v["peak_mib"], v["bytes_per_triangle"]), (2.0, 2048.0));
    }
}
