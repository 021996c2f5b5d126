//! Settings that change while cloths move.

use super::Stepper;
use crate::error::{Error, Result};
use crate::options::{Backend, Options};
use crate::quality::Chooser;

impl Stepper {
    /// Changes settings from the next frame on, while cloths keep moving.
    ///
    /// | may change | must stay, as their data was made with the stepper |
    /// |---|---|
    /// | `step`, `substeps`, `iterations`, `polish`, `quality`, `max_catch_up` | `backend` (`Auto` stands for the one that runs), `threads` |
    /// | `thickness`, `normals`, `sleep` | `solver`, `tethers`, `pyramid`, `tuning` |
    /// | `fused` from true to false | `fused` from false to true |
    ///
    /// Take [`Stepper::options`] and change what is to change. Errors on a setting out of range, and with the name of an option that
    /// must stay ([`Error::FixedOption`]); then nothing has changed.
    pub fn set_options(&mut self, options: Options) -> Result<()> {
        options.check()?;
        let Options { backend, threads, solver, tethers, pyramid, fused, tuning, .. } = *self.options();
        let same_backend = [Backend::Auto, backend, self.backend()].contains(&options.backend);
        let stays = [
            ("backend", same_backend),
            ("threads", options.threads == threads),
            ("solver", options.solver == solver),
            ("tethers", options.tethers == tethers),
            ("pyramid", options.pyramid == pyramid),
            ("fused", fused || !options.fused),
            ("tuning", options.tuning == tuning),
        ];
        if let Some((option, _)) = stays.into_iter().find(|(_, stays)| !stays) {
            return Err(Error::FixedOption { option });
        }
        self.guarded(|stepper| {
            stepper.change(Options { backend, ..options });
            Ok(())
        })
    }

    fn change(&mut self, options: Options) {
        if options.quality != self.world.control.options.quality {
            self.world.control.chooser = Chooser::default();
        }
        let coat = options.thickness != self.world.control.options.thickness;
        self.world.set_options(options);
        if coat {
            self.recoat();
        }
    }
}
