//! The bytes of a buffer, as a future that the device completes.

use std::future::poll_fn;
use std::pin::pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use super::lost::{guard, poll};
use crate::error::{Error, Result};

/// The answer to a request, and who waits for it.
#[derive(Default)]
struct Answer {
    mapped: Option<std::result::Result<(), wgpu::BufferAsyncError>>,
    waker: Option<Waker>,
}

/// A buffer that is mapped, or is to be. Ends that when it is dropped, as a future may be before it is ready.
struct Mapping<'a> {
    buffer: &'a wgpu::Buffer,
    answer: Arc<Mutex<Answer>>,
}

impl Mapping<'_> {
    fn answer(&self) -> MutexGuard<'_, Answer> {
        self.answer.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Mapping<'_> {
    fn drop(&mut self) {
        // After a refusal there is nothing to end.
        let refused = matches!(self.answer().mapped, Some(Err(_)));
        if !refused {
            self.buffer.unmap();
        }
    }
}

/// Asks for the contents of a buffer that the host may read, and hands its bytes over when they are there. To be called when the copy
/// into the buffer has been submitted. An error on a buffer that is mapped, or is being mapped, already.
pub(crate) async fn bytes<A>(
    device: &wgpu::Device,
    staging: &wgpu::Buffer,
    take: impl FnOnce(&[u8]) -> A,
) -> Result<A> {
    let answer: Arc<Mutex<Answer>> = Arc::default();
    let told = answer.clone();
    guard(device, || {
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            let waker = {
                let mut answer = told.lock().unwrap_or_else(PoisonError::into_inner);
                answer.mapped = Some(result);
                answer.waker.take()
            };
            // Outside of the lock, as the future may be polled at once.
            waker.into_iter().for_each(Waker::wake);
        });
        Ok(())
    })?;
    let mapping = Mapping { buffer: staging, answer };
    let arrived = poll_fn(|context| {
        let mut answer = mapping.answer();
        if let Some(result) = answer.mapped.clone() {
            return Poll::Ready(result);
        }
        answer.waker = Some(context.waker().clone());
        Poll::Pending
    });
    let failed = |e: &dyn std::fmt::Display| Error::ReadBack(e.to_string());
    arrived.await.map_err(|e| failed(&e))?;
    let view = staging.slice(..).get_mapped_range().map_err(|e| failed(&e))?;
    let taken = take(&view);
    drop(view);
    Ok(taken)
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
