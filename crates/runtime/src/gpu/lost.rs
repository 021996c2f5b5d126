//! Devices that are lost or out of memory: found out without the host's callbacks, and told as errors.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Waker};

use wgpu::{Buffer, BufferUsages, ErrorFilter};

use super::read_back::MAPPED;
use super::upload::empty;
use crate::error::{Error, Result};

/// A buffer that shows whether its device is lost.
pub(super) struct Pulse {
    probe: Buffer,
    refused: Arc<AtomicBool>,
}

impl Pulse {
    /// An error on a device that is lost already.
    pub fn new(device: &wgpu::Device) -> Result<Self> {
        if is_lost(device) {
            return Err(Error::DeviceLost);
        }
        Ok(Pulse { probe: empty(device, "pulse", 4, MAPPED), refused: Arc::default() })
    }

    /// Whether the device is lost, without waiting: a lost device refuses to map a buffer at once. About a microsecond. On the
    /// web, where the answer comes later, no device is.
    pub fn is_lost(&self) -> bool {
        if cfg!(target_family = "wasm") {
            return false;
        }
        self.refused.store(false, Ordering::Relaxed);
        let refused = self.refused.clone();
        self.probe.slice(..).map_async(wgpu::MapMode::Read, move |_| refused.store(true, Ordering::Relaxed));
        let lost = self.refused.load(Ordering::Relaxed);
        if !lost {
            self.probe.unmap();
        }
        lost
    }
}

/// The same of a device without a pulse: makes a buffer.
pub(crate) fn is_lost(device: &wgpu::Device) -> bool {
    let usage = BufferUsages::COPY_SRC;
    let label = Some("pulse");
    let scope = device.push_error_scope(ErrorFilter::OutOfMemory);
    let made = device.create_buffer(&wgpu::BufferDescriptor { label, size: 4, usage, mapped_at_creation: true });
    let full = ready(scope.pop()).is_some();
    !full && made.get_mapped_range_mut(..).is_err()
}

/// Runs what makes objects on a device. Errors of the device are its result and do not reach the host's handler, whose default
/// is to panic. In a browser, where they are told later, they do reach it.
pub(crate) fn guard<T>(device: &wgpu::Device, run: impl FnOnce() -> Result<T>) -> Result<T> {
    if cfg!(target_family = "wasm") {
        return run();
    }
    let scopes = FILTERS.map(|filter| device.push_error_scope(filter));
    let result = run();
    // The last that was pushed is the first to be popped.
    let raised = scopes.into_iter().rev().filter_map(|scope| ready(scope.pop())).collect();
    outcome(device, result, raised)
}

/// The same where errors may be told later, as in a browser. `run` is called when the future is first polled.
pub(crate) async fn guard_async<T>(device: &wgpu::Device, run: impl FnOnce() -> Result<T>) -> Result<T> {
    let scopes = FILTERS.map(|filter| device.push_error_scope(filter));
    let result = run();
    let popped: Vec<_> = scopes.into_iter().rev().map(|scope| scope.pop()).collect();
    let mut raised = Vec::new();
    for error in popped {
        raised.extend(error.await);
    }
    outcome(device, result, raised)
}

const FILTERS: [ErrorFilter; 3] = [ErrorFilter::OutOfMemory, ErrorFilter::Internal, ErrorFilter::Validation];

fn outcome<T>(device: &wgpu::Device, result: Result<T>, raised: Vec<wgpu::Error>) -> Result<T> {
    match result {
        Ok(done) if raised.is_empty() => Ok(done),
        // One loss raises many errors.
        _ if is_lost(device) => Err(Error::DeviceLost),
        result => raised.into_iter().map(typed).reduce(worse).map_or(result, Err),
    }
}

fn typed(error: wgpu::Error) -> Error {
    match error {
        wgpu::Error::OutOfMemory { .. } => Error::OutOfMemory,
        other => Error::Device(other.to_string().split_whitespace().collect::<Vec<_>>().join(" ")),
    }
}

/// Buffers that there was no memory for cause validation errors.
fn worse(a: Error, b: Error) -> Error {
    if matches!(b, Error::OutOfMemory) { b } else { a }
}

/// The error of a scope; outside the web it is there at once.
fn ready(error: impl Future<Output = Option<wgpu::Error>>) -> Option<wgpu::Error> {
    match pin!(error).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(error) => error,
        Poll::Pending => None,
    }
}

/// [`wgpu::Device::poll`], which panics where the driver tells of a loss there first.
pub(super) fn poll(device: &wgpu::Device, how: wgpu::PollType) -> Result<()> {
    #[cfg(test)]
    WAITS.set(WAITS.get() + u32::from(!matches!(how, wgpu::PollType::Poll)));
    match catch_unwind(AssertUnwindSafe(|| device.poll(how))) {
        Ok(polled) => polled.map(|_| ()).map_err(|e| Error::ReadBack(e.to_string())),
        Err(_) => Err(Error::DeviceLost),
    }
}

#[cfg(test)]
thread_local! {
    /// How often this thread has waited for a device.
    pub(super) static WAITS: std::cell::Cell<u32> = const { std::cell::Cell::new(0) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_device_have_types() {
        let source = || Box::new(std::io::Error::other("no room"));
        let full = || typed(wgpu::Error::OutOfMemory { source: source() });
        let wrong = || typed(wgpu::Error::Validation { source: source(), description: "In a\n  bind group".into() });
        assert!(matches!(full(), Error::OutOfMemory));
        assert!(matches!(wrong(), Error::Device(text) if text.ends_with("In a bind group")));
        for (a, b) in [(full(), wrong()), (wrong(), full())] {
            assert!(matches!(worse(a, b), Error::OutOfMemory));
        }
    }
}
