//! The self-check of a device: compares its results with the CPU's at its first use, in milliseconds.
//!
//! Drivers have faults that no limit and no feature shows: a shader compiles, runs, and leaves wrong numbers. A device is
//! therefore tried on a small seamed cloth before [`crate::Backend::Auto`] takes it.

mod probe;

use std::sync::{Mutex, PoisonError};

use web_time::Instant;

use crate::error::{Error, Result};
#[cfg(not(target_family = "wasm"))]
use crate::gpu::block_on;
use crate::gpu::{Pipelines, is_lost};
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
    fn new(device: &wgpu::Device, start: Instant, mismatches: Vec<Mismatch>) -> Self {
        SelfCheck { adapter: name(&device.adapter_info()), ms: start.elapsed().as_secs_f64() * 1e3, mismatches }
    }

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

type Known = Vec<((wgpu::AdapterInfo, wgpu::Limits), SelfCheck)>;

/// The checks so far in this process.
static CHECKED: Mutex<Known> = Mutex::new(Vec::new());

/// Checks a device against the CPU backend, once per adapter and limits in a process; later calls return the first result.
///
/// Two small seamed cloths with a collider make two steps, as whole frames in one dispatch and pass by pass. Positions must
/// be within 1e-5 m of the CPU's, normals within 2e-3, inverse masses and the two sides of seams bit for bit. Submits to
/// the queue and waits: milliseconds, and up to a second where a software adapter compiles the shaders. Errors of the device
/// are results of the check. A page in a browser cannot wait, and awaits [`self_check_async`].
#[cfg(not(target_family = "wasm"))]
pub fn self_check(device: &wgpu::Device, queue: &wgpu::Queue) -> SelfCheck {
    check_with((device, queue), None)
}

/// The same with the host's cache of pipelines.
#[cfg(not(target_family = "wasm"))]
fn check_with(handles: (&wgpu::Device, &wgpu::Queue), cache: Option<&wgpu::PipelineCache>) -> SelfCheck {
    let device = handles.0;
    // Held throughout, so that threads that ask at the same time wait for one check.
    let mut checked = CHECKED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = find(&checked, device) {
        return known;
    }
    let start = Instant::now();
    let found = block_on(device, async { Ok(probe::run(probe::On { handles, cache }).await) });
    let mismatches = found.unwrap_or_else(|error| vec![Mismatch::Failed(error.to_string())]);
    keep(&mut checked, device, SelfCheck::new(device, start, mismatches))
}

/// [`self_check`] without waiting. In a browser it has to have ended before [`crate::Stepper::new`], which else has a warning
/// ([`Warning::Unchecked`]). Elsewhere the host polls the device meanwhile ([`wgpu::Device::poll`]).
pub async fn self_check_async(device: &wgpu::Device, queue: &wgpu::Queue) -> SelfCheck {
    if let Some(known) = known(device) {
        return known;
    }
    let start = Instant::now();
    let mismatches = probe::run(probe::On { handles: (device, queue), cache: None }).await;
    let check = SelfCheck::new(device, start, mismatches);
    keep(&mut CHECKED.lock().unwrap_or_else(PoisonError::into_inner), device, check)
}

fn known(device: &wgpu::Device) -> Option<SelfCheck> {
    find(&CHECKED.lock().unwrap_or_else(PoisonError::into_inner), device)
}

fn find(checked: &Known, device: &wgpu::Device) -> Option<SelfCheck> {
    let key = (device.adapter_info(), device.limits());
    checked.iter().find(|(k, _)| *k == key).map(|(_, known)| known.clone())
}

/// Keeps a check for later calls, the first of those that were made at the same time. A loss says nothing of the device that is made next.
fn keep(checked: &mut Known, device: &wgpu::Device, check: SelfCheck) -> SelfCheck {
    if let Some(known) = find(checked, device) {
        return known;
    }
    if !is_lost(device) {
        checked.push(((device.adapter_info(), device.limits()), check.clone()));
    }
    check
}

/// An adapter in words: its name, its interface and its driver.
fn name(info: &wgpu::AdapterInfo) -> String {
    let driver = [info.driver.trim(), info.driver_info.trim()].join(" ");
    let driver = if driver.trim().is_empty() { String::new() } else { format!(", {}", driver.trim()) };
    // Browsers may keep the name to themselves.
    let name = if info.name.trim().is_empty() { "of no name" } else { info.name.trim() };
    format!("{name} ({}{driver})", info.backend)
}

/// [`decide`] of a device, which is checked now if it was not before.
#[cfg(not(target_family = "wasm"))]
pub(super) fn consider(
    backend: Backend,
    handles: (&wgpu::Device, &wgpu::Queue),
    pipelines: Option<&Pipelines>,
) -> Result<(bool, Option<Warning>)> {
    decide(backend, Some(&check_with(handles, pipelines.and_then(Pipelines::cache))))
}

/// [`decide`] of a device that the host has checked, or has not.
#[cfg(target_family = "wasm")]
pub(super) fn consider(
    backend: Backend,
    (device, _): (&wgpu::Device, &wgpu::Queue),
    _: Option<&Pipelines>,
) -> Result<(bool, Option<Warning>)> {
    match known(device) {
        Some(check) => decide(backend, Some(&check)),
        None => Ok((false, Some(Warning::Unchecked { name: name(&device.adapter_info()) }))),
    }
}

/// Whether the CPU steps, and what there is to say about the device. `check` is that of the host's device, if it gave one.
fn decide(backend: Backend, check: Option<&SelfCheck>) -> Result<(bool, Option<Warning>)> {
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
