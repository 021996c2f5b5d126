//! The settings that are in force, and how they change from frame to frame.

use crate::choose::{Choice, Follow, Hold, Settings, Wish};
use crate::clock::Clock;
use crate::options::Options;
use crate::quality::{Chooser, Levers, Mix, Quality};
use crate::scene::Scene;
use crate::state::ControlState;

/// Settings, and what decides them.
#[derive(Clone)]
pub struct Control {
    /// With all decided that the host left open.
    pub options: Settings,
    /// Why so.
    pub choice: Choice,
    /// Wishes of each cloth, as of the last decision.
    wishes: Vec<Wish>,
    /// Keeps substeps up with the speed of colliders.
    pub follow: Follow,
    pub clock: Clock,
    /// Chooses substeps and rounds of polish.
    pub chooser: Chooser,
    /// As [`Levers::round`].
    pub round: Option<f64>,
}

impl Control {
    pub fn new(options: Options, scene: &Scene) -> Self {
        let (options, choice) = Settings::new(options, scene);
        let (clock, follow) = (Clock::new(&options), Follow::new(&options, scene));
        let wishes = Wish::of(&options, scene);
        Control { options, choice, wishes, follow, clock, chooser: Chooser::default(), round: None }
    }

    /// Starts the clock again, before anything has moved.
    pub fn start(&mut self) {
        self.clock = Clock::new(&self.options);
    }

    /// How the tethers of a cloth are made, by its index.
    pub fn hold(&self, cloth: usize) -> Hold {
        let plain = Hold { most: self.options.tethers, slack: 1.0 };
        self.options.hold.get(cloth).copied().unwrap_or(plain)
    }

    /// Takes other settings from the next step on.
    pub fn set(&mut self, (settings, choice): (Settings, Choice), scene: &Scene) {
        (self.follow, self.wishes) = (Follow::new(&settings, scene), Wish::of(&settings, scene));
        (self.options, self.choice) = (settings, choice);
        self.clock.change(&self.options);
    }

    /// Takes another number of substeps.
    pub fn set_substeps(&mut self, substeps: u32) {
        if substeps != self.options.substeps {
            self.options.substeps = substeps;
            self.clock.change(&self.options);
        }
    }

    /// Decides again what the host left open; whether the rounds of polish change with it.
    pub fn decide(&mut self, scene: &Scene) -> bool {
        let (mut settings, choice) = Settings::new(self.options.given().clone(), scene);
        let polish = self.options.polish;
        // Numbers that are chosen from frame to frame go on, and tethers were made with the stepper.
        if self.options.quality != Quality::Fixed {
            settings.substeps = self.options.substeps;
        }
        if self.round.is_some() {
            settings.polish = self.options.polish;
        }
        settings.hold = std::mem::take(&mut self.options.hold);
        self.set((settings, choice), scene);
        polish != self.options.polish
    }

    /// Takes in that a cloth comes, which is the only one of a scene among the same colliders; whether the rounds of polish change.
    /// Numbers that the host left open rise to those that it asks for. The first cloth decides them.
    pub fn join(&mut self, alone: &Scene) -> bool {
        let polish = self.options.polish;
        let (settings, choice) = Settings::new(self.options.given().clone(), alone);
        if self.wishes.is_empty() {
            self.set((settings, choice), alone);
            self.chooser = Chooser::default();
            // No cloth has made a step of another length.
            self.clock.dt_old = self.clock.dt;
            return polish != self.options.polish;
        }
        let wishes = Wish::of(&settings, alone);
        let wish = Wish::most(&wishes).unwrap_or(Wish { substeps: 0, stirred: 0, polish: 0 });
        let fast = Some(Follow::new(&settings, alone)).filter(|_| choice.substeps > wish.substeps);
        self.follow.join(wish, fast.as_ref());
        self.options.hold.extend(&settings.hold);
        self.wishes.extend(wishes);
        let more_steps = self.options.quality == Quality::Fixed && choice.substeps > self.options.substeps;
        let more_rounds = self.round.is_none() && choice.polish > self.options.polish;
        if more_steps {
            self.set_substeps(choice.substeps);
        }
        if more_rounds {
            self.options.polish = choice.polish;
        }
        if more_steps || more_rounds {
            self.choice = Choice { substeps: self.options.substeps, polish: self.options.polish, ..choice };
        }
        more_rounds
    }

    /// Takes in that a cloth leaves; whether the rounds of polish change. Numbers that it alone asked for fall to what the others
    /// ask for: substeps gradually. After the last one nothing changes.
    pub fn leave(&mut self, cloth: usize) -> bool {
        let gone = self.wishes.remove(cloth);
        self.options.hold.remove(cloth);
        let Some(rest) = Wish::most(&self.wishes) else { return false };
        self.follow.leave(gone, rest);
        let chosen = self.choice.given == [false; 2] && self.round.is_none() && self.options.polish == gone.polish;
        let falls = chosen && rest.polish < gone.polish;
        if falls {
            self.options.polish = rest.polish;
        }
        falls
    }

    /// Chooses how many substeps and rounds of polish the next frames have; whether the rounds change.
    pub fn choose(&mut self, scene: &Scene) -> bool {
        let now = Mix { substeps: self.options.substeps, rounds: self.options.polish };
        let next = match self.options.quality {
            Quality::Fixed => Mix { substeps: self.follow.next(now.substeps, scene), ..now },
            quality => {
                let fewest = self.follow.fewest(scene);
                let levers = Levers { round: self.round, start: self.choice.polish, fewest };
                self.chooser.next(quality, now, &levers)
            }
        };
        self.set_substeps(next.substeps);
        self.options.polish = next.rounds;
        next.rounds != now.rounds
    }

    /// State that a continuation with the same bits needs.
    pub fn save(&self, due: f64) -> ControlState {
        let (clock, chooser, follow) = (self.clock.numbers(), self.chooser.numbers(), self.follow.numbers());
        ControlState { clock, chooser, follow, due, substeps: self.options.substeps, polish: self.options.polish }
    }

    /// Continues from there, with substeps and polish of then where the host gave none; whether the rounds of polish change.
    pub fn resume(&mut self, state: &ControlState, scene: &Scene) -> bool {
        let polish = self.options.polish;
        let given = self.options.given();
        let (mut settings, choice) = Settings::new(given.clone(), scene);
        if given.quality != Quality::Fixed || given.substeps.is_none() {
            settings.substeps = state.substeps;
        }
        // An error that is asked for chooses the rounds beside substeps that are given.
        if given.polish.is_none() && (given.substeps.is_none() || given.quality.target().is_some()) {
            settings.polish = state.polish;
        }
        settings.hold = std::mem::take(&mut self.options.hold);
        self.set((settings, choice), scene);
        self.follow.resume(state.follow);
        self.chooser.resume(&state.chooser);
        self.clock.resume(state.clock);
        polish != self.options.polish
    }

    /// To be called after the steps of a frame.
    pub fn tick(&mut self, steps: u32) {
        let seconds = f64::from(steps) * self.clock.dt;
        self.chooser.stepped(seconds);
        self.follow.stepped(seconds);
        (0..steps).for_each(|_| self.clock.tick());
    }
}
