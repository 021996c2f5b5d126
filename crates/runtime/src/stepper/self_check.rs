//! The self-check of a device: compares its results with the CPU's at its first use, in milliseconds.
//!
//! Drivers have faults that no limit and no feature shows: a shader compiles, runs, and leaves wrong numbers. A device is
//! therefore tried on a small seamed cloth before [`crate::Backend::Auto`] takes it.

mod probe;

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use crate::error::{Error, Result};
use crate::gpu::is_lost;
use crate::limits::Warning;
use crate::options::Backend;

/// The result of the self-check of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfCheck {
    /// The adapter's name, its interface and its driver.
    pub adapter: String,
    /// Wall time \[ms\], most of it compilation of shaders.
    pub ms: f64,
    /// The results that are wrong. Empty where the device passed.
    pub mismatches: Vec<Mismatch>,
}

impl SelfCheck {
    /// Whether all results were right.
    pub fn passed(&self) -> bool {
        self.mismatches.is_empty()
    }

    /// The mismatches in words, separated by semicolons.
    pub fn found(&self) -> String {
        self.mismatches.iter().map(Mismatch::to_string).collect::<Vec<_>>().join("; ")
    }
}

/// A wrong result of a device.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Mismatch {
    /// Numbers differ from those of the CPU by more than rounding explains.
    #[error("{run}: {what} differ from the CPU's by {by:.1e} (limit {limit:.0e})")]
    Apart {
        /// How the steps were run.
        run: &'static str,
        /// The list that differs.
        what: &'static str,
        /// The largest difference, infinite where a number is not finite.
        by: f64,
        /// The largest difference that rounding explains.
        limit: f64,
    },
    /// Duplicates of a seam point must have the same bits.
    #[error("{run}: {what} of {count} seam points are not the same bits on both sides")]
    Seam {
        /// How the steps were run.
        run: &'static str,
        /// The list that differs.
        what: &'static str,
        /// Seam points with a difference.
        count: usize,
    },
    /// The device did not run the check to its end.
    #[error("{0}")]
    Failed(String),
}

/// Checks a device against the CPU backend, once per adapter and limits in a process; later calls return the first result.
///
/// Two small seamed cloths with a collider make two steps, as whole frames in one dispatch and pass by pass. Positions must
/// be within 1e-5 m of the CPU's, normals within 2e-3, inverse masses and the two sides of seams bit for bit. Submits to
/// the queue and waits: milliseconds, and up to a second where a software adapter compiles the shaders. Errors of the device
/// are results of the check. On the web, where nothing can wait, every device passes unchecked.
pub fn self_check(device: &wgpu::Device, queue: &wgpu::Queue) -> SelfCheck {
    static CHECKED: Mutex<Vec<((wgpu::AdapterInfo, wgpu::Limits), SelfCheck)>> = Mutex::new(Vec::new());
    let key = (device.adapter_info(), device.limits());
    // Held throughout, so that threads that ask at the same time wait for one check.
    let mut checked = CHECKED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, known)) = checked.iter().find(|(k, _)| *k == key) {
        return known.clone();
    }
    let start = Instant::now();
    let mismatches = if cfg!(target_family = "wasm") { Vec::new() } else { probe::run(device, queue) };
    let check = SelfCheck { adapter: name(&key.0), ms: start.elapsed().as_secs_f64() * 1e3, mismatches };
    // A loss says nothing of the device that is made next.
    if !is_lost(device) {
        checked.push((key, check.clone()));
    }
    check
}

/// An adapter in words: its name, its interface and its driver.
fn name(info: &wgpu::AdapterInfo) -> String {
    let driver = [info.driver.trim(), info.driver_info.trim()].join(" ");
    let driver = if driver.trim().is_empty() { String::new() } else { format!(", {}", driver.trim()) };
    format!("{} ({}{driver})", info.name, info.backend)
}

/// Whether the CPU steps, and what there is to say about the device. `check` is that of the host's device, if it gave one.
pub(super) fn decide(backend: Backend, check: Option<&SelfCheck>) -> Result<(bool, Option<Warning>)> {
    let Some(check) = check.filter(|_| backend != Backend::Cpu) else {
        return if backend == Backend::Gpu { Err(Error::NoGpu("Backend::Gpu")) } else { Ok((true, None)) };
    };
    let used = backend == Backend::Gpu;
    let warning =
        (!check.passed()).then(|| Warning::Adapter { name: check.adapter.clone(), found: check.found(), used });
    Ok((warning.is_some() && !used, warning))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(mismatches: Vec<Mismatch>) -> SelfCheck {
        SelfCheck { adapter: "test (gl)".into(), ms: 1.0, mismatches }
    }

    #[test]
    fn auto_takes_only_a_device_that_passed_and_an_explicit_gpu_runs_with_a_warning() {
        let good = check(Vec::new());
        let apart = Mismatch::Apart { run: "pass by pass", what: "normals", by: 0.47, limit: 2e-3 };
        let bad = check(vec![apart]);
        let run = |backend, check| decide(backend, check).map(|(cpu, warning)| (cpu, warning.map(|w| w.to_string())));
        assert_eq!(run(Backend::Auto, None).unwrap(), (true, None));
        assert_eq!(run(Backend::Auto, Some(&good)).unwrap(), (false, None));
        assert_eq!(run(Backend::Gpu, Some(&good)).unwrap(), (false, None));
        assert_eq!(run(Backend::Cpu, Some(&bad)).unwrap(), (true, None));
        assert!(matches!(run(Backend::Gpu, None), Err(Error::NoGpu(_))));
        let (cpu, warning) = run(Backend::Auto, Some(&bad)).unwrap();
        let warning = warning.unwrap();
        assert!(cpu && warning.contains("test (gl)") && warning.contains("normals differ"), "{warning}");
        assert!(warning.contains("4.7e-1") && warning.contains("CPU backend runs instead"), "{warning}");
        let (cpu, warning) = run(Backend::Gpu, Some(&bad)).unwrap();
        assert!(!cpu && warning.unwrap().contains("explicitly"));
    }
}
