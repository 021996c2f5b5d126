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
    let raised = scopes.into_iter().rev().filter_map(|scope| ready(scope.pop()));
    #[cfg(test)]
    let raised = raised.chain(FULL.take().then(tests::full));
    outcome(device, result, raised.collect())
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
    /// Whether the next guarded call on this thread finds the memory of the device full.
    static FULL: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::adapter::device;
    use crate::gpu::read_back;
    use crate::{Backend, Flat, Options, Scene, Stepper};

    type Handles = (wgpu::Device, wgpu::Queue);

    pub fn full() -> wgpu::Error {
        wgpu::Error::OutOfMemory { source: Box::new(std::io::Error::other("no room")) }
    }

    /// As many sheets.
    fn stepper(count: usize, (device, queue): &Handles) -> Result<Stepper> {
        let mut scene = Scene::new("sheets");
        for n in 0..count as u32 {
            let mut cloth = Flat::square("sheet", 9 + n).cloth()?;
            cloth.set_pinned(0, true)?;
            scene.cloths.push(cloth);
        }
        let options = Options { backend: Backend::Gpu, substeps: Some(3), ..Options::default() };
        Stepper::new(scene, options, Some((device, queue)))
    }

    fn frames(stepper: &mut Stepper, (device, queue): &Handles, count: u32) -> Result<()> {
        (0..count).try_for_each(|_| {
            let mut encoder = device.create_command_encoder(&Default::default());
            stepper.record(&mut encoder, 1.0 / 60.0)?;
            queue.submit([encoder.finish()]);
            Ok(())
        })
    }

    fn bits(stepper: &Stepper, (device, queue): &Handles) -> Vec<Vec<[u32; 4]>> {
        let all = (0..stepper.handles().len()).map(|c| stepper.buffers(c).unwrap());
        let of = |span| read_back(device, queue, span).unwrap().into_iter().map(|p| p.map(f32::to_bits)).collect();
        all.map(|buffers| of(&buffers.now)).collect()
    }

    #[test]
    fn a_device_without_memory_is_a_typed_error_and_cloth_goes_on() {
        let Some(handles) = device() else { return };
        // They check the adapter, and later ones do not.
        let (mut cloths, mut others) = (stepper(2, &handles).unwrap(), stepper(2, &handles).unwrap());
        FULL.set(true);
        assert!(matches!(stepper(2, &handles), Err(Error::OutOfMemory)));

        // A cloth that does not fit leaves the others as they are.
        frames(&mut cloths, &handles, 3).unwrap();
        FULL.set(true);
        let added = cloths.add_cloth(Flat::square("late", 12).cloth().unwrap());
        assert!(matches!(added, Err(Error::OutOfMemory)) && cloths.handles().len() == 2, "{added:?}");
        frames(&mut cloths, &handles, 2).unwrap();
        frames(&mut others, &handles, 5).unwrap();
        assert!(bits(&cloths, &handles) == bits(&others, &handles));

        // After a frame that finds no memory the stepper refuses all calls until it has recovered, on the same device.
        let saved = cloths.snapshot().unwrap();
        frames(&mut cloths, &handles, 2).unwrap();
        FULL.set(true);
        for _ in 0..2 {
            assert!(matches!(frames(&mut cloths, &handles, 1), Err(Error::OutOfMemory)));
        }
        assert!(matches!(cloths.snapshot(), Err(Error::OutOfMemory)));
        FULL.set(true);
        assert!(matches!(cloths.recover(&handles.0, &handles.1), Err(Error::OutOfMemory)));
        cloths.recover(&handles.0, &handles.1).unwrap();
        others.restore(&saved).unwrap();
        for stepper in [&mut cloths, &mut others] {
            frames(stepper, &handles, 4).unwrap();
        }
        assert!(bits(&cloths, &handles) == bits(&others, &handles));
    }

    #[test]
    fn errors_of_a_device_have_types() {
        let source = || Box::new(std::io::Error::other("no room"));
        let full = || typed(full());
        let wrong = || typed(wgpu::Error::Validation { source: source(), description: "In a\n  bind group".into() });
        assert!(matches!(full(), Error::OutOfMemory));
        assert!(matches!(wrong(), Error::Device(text) if text.ends_with("In a bind group")));
        for (a, b) in [(full(), wrong()), (wrong(), full())] {
            assert!(matches!(worse(a, b), Error::OutOfMemory));
        }
    }
}
