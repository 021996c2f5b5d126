//! Times of passes on the device.

use super::Stepper;
use crate::gpu::PassTime;

impl Stepper {
    /// Times every pass of the frames that are recorded from here on, or ends that. Returns false, and does nothing, without a device
    /// and on one without `Features::TIMESTAMP_QUERY` ([`crate::device_features`] requests it), and where the CPU steps.
    ///
    /// Each run of dispatches of a shader gets a compute pass of its own, with its name, which costs some microseconds each:
    /// a frame takes longer than without. At most 2,048 runs per frame are timed, and none while four frames are under way. A
    /// stepper that recovers from a lost device times nothing until it is asked again.
    pub fn time_passes(&mut self, on: bool) -> bool {
        self.cpu.is_none() && self.gpu.as_mut().is_some_and(|gpu| gpu.time_passes(on))
    }

    /// The times of the passes in the last frame that has arrived ([`Stepper::settle`]), in the order of their first run; empty
    /// before.
    pub fn pass_times(&self) -> &[PassTime] {
        self.gpu.as_ref().map_or(&[], |gpu| gpu.pass_times())
    }
}
