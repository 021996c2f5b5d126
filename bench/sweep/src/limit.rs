//! Limits of a child: CPU time and address space.

use crate::Failure;

/// CPU seconds beyond the limit that the measuring after a build may take.
const FOR_MEASURING_S: u64 = 40;

/// Limits this process. A build that takes a little too long is still measured; beyond that the system ends it.
#[cfg(unix)]
pub fn set(seconds: u64, mib: u64) -> Result<(), Failure> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let cpu = seconds.saturating_add(FOR_MEASURING_S);
    setrlimit(Resource::Cpu, Rlimit { current: Some(cpu), maximum: Some(cpu.saturating_add(2)) })?;
    let bytes = mib.saturating_mul(1 << 20);
    setrlimit(Resource::As, Rlimit { current: Some(bytes), maximum: Some(bytes) })?;
    // A core file of a process that was ended is unused.
    setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) })?;
    Ok(())
}

/// This system has no limits that a process can set for itself; the parent's clock ends the child.
#[cfg(not(unix))]
pub fn set(seconds: u64, mib: u64) -> Result<(), Failure> {
    let _ = (seconds, mib, FOR_MEASURING_S);
    Ok(())
}

/// User and system time of this process, all threads \[s\].
#[cfg(unix)]
pub fn cpu_seconds() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

/// Wall time instead, where CPU time is not known.
#[cfg(not(unix))]
pub fn cpu_seconds() -> f64 {
    use std::sync::OnceLock;
    use std::time::Instant;
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}
