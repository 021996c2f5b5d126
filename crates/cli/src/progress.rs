//! A progress bar for the stage that is under way.

use std::sync::Mutex;
use std::time::Duration;

use gimage::progress::{Progress, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// One bar on stderr, which each stage takes over from the one before.
#[derive(Debug)]
pub struct Bar {
    bar: ProgressBar,
    stage: Mutex<Option<Stage>>,
}

impl Bar {
    /// A bar, shown at once; `None` shows nothing.
    pub fn new(show: bool, name: &str) -> Self {
        let bar = ProgressBar::with_draw_target(
            Some(1),
            if show { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() },
        );
        if show {
            let template = "{spinner} {prefix}  {msg:<9} [{bar:30}] {pos}/{len}  {elapsed}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_prefix(name.to_owned());
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Bar { bar, stage: Mutex::new(None) }
    }
}

impl Progress for Bar {
    fn begin(&self, stage: Stage, steps: u64) {
        if let Ok(mut current) = self.stage.lock() {
            *current = Some(stage);
            self.bar.set_message(stage.name());
            self.bar.set_length(steps.max(1));
            self.bar.set_position(0);
        }
    }

    fn step(&self, stage: Stage) {
        // A late step of an earlier stage must not move the bar of this one.
        if self.stage.lock().is_ok_and(|current| *current == Some(stage)) {
            self.bar.inc(1);
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
