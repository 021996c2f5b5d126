//! The bytes of a buffer, as a future that the device completes.

use std::future::poll_fn;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

use super::lost::poll;
use crate::error::{Error, Result};

type Mapped = std::result::Result<(), wgpu::BufferAsyncError>;

/// A buffer that is mapped, or is to be. Ends that when it is dropped, as a future may be before it is ready.
struct Mapping<'a>(&'a wgpu::Buffer);

impl Drop for Mapping<'_> {
    fn drop(&mut self) {
        self.0.unmap();
    }
}

/// Asks for the contents of a buffer that the host may read, and hands its bytes over when they are there. To be called when the copy
/// into the buffer has been submitted. The request is made at once, the future may be awaited later.
pub(crate) fn bytes<A>(staging: &wgpu::Buffer, take: impl FnOnce(&[u8]) -> A) -> impl Future<Output = Result<A>> {
    let shared: Arc<Mutex<(Option<Mapped>, Option<Waker>)>> = Arc::default();
    let answer = shared.clone();
    staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        let mut answer = answer.lock().unwrap_or_else(PoisonError::into_inner);
        answer.0 = Some(result);
        if let Some(waker) = answer.1.take() {
            waker.wake();
        }
    });
    let arrived = poll_fn(move |context| {
        let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(result) = shared.0.take() {
            return Poll::Ready(result);
        }
        shared.1 = Some(context.waker().clone());
        Poll::Pending
    });
    let mapping = Mapping(staging);
    async move {
        let failed = |e: &dyn std::fmt::Display| Error::ReadBack(e.to_string());
        if let Err(e) = arrived.await {
            // There is nothing to end.
            std::mem::forget(mapping);
            return Err(failed(&e));
        }
        let view = staging.slice(..).get_mapped_range().map_err(|e| failed(&e))?;
        let taken = take(&view);
        drop(view);
        drop(mapping);
        Ok(taken)
    }
}

/// Runs a future that waits for nothing but a device. A page in a browser cannot: there the device completes no future before the caller
/// returns, and the result is an error.
pub(crate) fn block_on<A>(device: &wgpu::Device, future: impl Future<Output = Result<A>>) -> Result<A> {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(done) = future.as_mut().poll(&mut context) {
            return done;
        }
        if cfg!(target_family = "wasm") {
            return Err(Error::ReadBack("a page in a browser cannot wait: use the async form of the call".into()));
        }
        poll(device, wgpu::PollType::wait_indefinitely())?;
    }
}
