//! Frames on a clock.

use gimage_bench_host::{FRAME, Gpu, Host};
use gimage_runtime::{Options, Result};

use crate::scenes::{Action, Case};

/// Frames before the clock starts: pipelines are made, and buffers first touched.
const WARM_UP: u32 = 3;

/// A case made ready, with the substeps and threads of the run.
pub fn host<'a>(case: &Case, run: &Options, gpu: Option<&'a Gpu>) -> Result<Host<'a>> {
    let options = Options { substeps: run.substeps, threads: run.threads, ..case.options.clone() };
    let mut host = Host::new(case.scene.clone(), options, gpu)?;
    match case.action {
        Action::None => {}
        Action::Cut => host.stepper.cut([0.5, 0.5, 3.0], [-4.0, 0.4, -2.0], [5.0, 0.4, -2.0])?,
        Action::Sleep => host.stepper.set_asleep(0, true)?,
    }
    Ok(host)
}

/// Milliseconds of each frame: from recording to the end of the work, and by the clock of the device, if it has one.
pub fn time(host: &mut Host, frames: u32) -> Result<Vec<(f64, Option<f64>)>> {
    for _ in 0..WARM_UP {
        host.timed(FRAME)?;
    }
    (0..frames).map(|_| Ok((host.timed(FRAME)?, host.device_ms()))).collect()
}
