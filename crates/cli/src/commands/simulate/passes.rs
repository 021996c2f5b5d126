//! Times of passes on the GPU, from some frames of a run.

use gimage_runtime::PassTime;
use serde_json::{Value, json};

/// One frame in this number is timed pass by pass. It takes longer, and does not count among the times of frames.
const EVERY: u32 = 16;

/// The times of each shader.
#[derive(Default)]
pub struct PassTimes(Vec<(PassTime, Vec<f64>)>);

impl PassTimes {
    /// Whether a frame is timed pass by pass: not the first one, as a device may still make something for it.
    pub fn is_due(frame: u32) -> bool {
        frame % EVERY == 2
    }

    /// Takes in a frame.
    pub fn take(&mut self, frame: Vec<PassTime>) {
        for time in frame {
            match self.0.iter_mut().find(|(of, _)| of.shader == time.shader) {
                Some((of, all)) => {
                    all.push(time.ms);
                    *of = time;
                }
                None => {
                    let all = vec![time.ms];
                    self.0.push((time, all));
                }
            }
        }
    }

    /// The median of each shader, and its dispatches in the last of these frames.
    pub fn json(&self) -> Vec<Value> {
        let of = |(time, all): &(PassTime, Vec<f64>)| {
            let mut all = all.clone();
            all.sort_by(f64::total_cmp);
            json!({"shader": time.shader, "dispatches": time.dispatches, "ms_median": all[all.len() / 2], "frames": all.len()})
        };
        self.0.iter().map(of).collect()
    }
}
