//! Small buffers on their way to the host, without waiting.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::read_back::MAPPED;
use super::upload::empty;
use crate::error::{Error, Result};

/// Most read-backs of one kind in flight.
const MOST: u32 = 4;

/// Buffers of one size, made when they are first needed.
#[derive(Default)]
pub(super) struct Staging {
    size: u64,
    free: Vec<wgpu::Buffer>,
    made: u32,
}

impl Staging {
    /// A buffer to be copied to; none where as many as there may be are in flight. With another size than before, the buffers of
    /// before are dropped when they have arrived.
    pub fn take(&mut self, device: &wgpu::Device, label: &str, size: u64) -> Option<Parcel> {
        if self.size != size {
            *self = Staging { size, ..Staging::default() };
        }
        let new = || {
            self.made += u32::from(self.made <= MOST);
            (self.made <= MOST).then(|| empty(device, label, size, MAPPED))
        };
        let staging = self.free.pop().or_else(new)?;
        Some(Parcel { staging, mapping: None })
    }

    /// Keeps the buffer of a parcel that has arrived.
    pub fn put_back(&mut self, parcel: Parcel) {
        if parcel.staging.size() == self.size {
            self.free.push(parcel.staging);
        }
    }
}

/// A buffer that is copied to, and then mapped.
pub(super) struct Parcel {
    pub staging: wgpu::Buffer,
    mapping: Option<Receiver<std::result::Result<(), wgpu::BufferAsyncError>>>,
}

impl Parcel {
    /// Asks for the contents once; to be called when the copy has been submitted.
    pub fn ask(&mut self) {
        if self.mapping.is_some() {
            return;
        }
        let (send, receive) = channel();
        self.staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // Nobody listens if the stepper is gone.
            let _ = send.send(result);
        });
        self.mapping = Some(receive);
    }

    /// The contents, if they have arrived since the device was polled.
    pub fn open<A>(&self, read: impl FnOnce(&[u8]) -> A) -> Result<Option<A>> {
        let Some(mapping) = &self.mapping else { return Ok(None) };
        match mapping.try_recv() {
            Err(TryRecvError::Empty) => return Ok(None),
            Err(e) => return Err(failed(&e)),
            Ok(result) => result.map_err(|e| failed(&e))?,
        }
        let bytes = self.staging.slice(..).get_mapped_range().map_err(|e| failed(&e))?;
        let taken = read(&bytes);
        drop(bytes);
        self.staging.unmap();
        Ok(Some(taken))
    }
}

fn failed(e: &dyn std::fmt::Display) -> Error {
    Error::ReadBack(e.to_string())
}
