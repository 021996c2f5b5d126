//! Cloths that follow joints: where these are, where they go in the next frame, and which particles go with them.

use std::sync::Arc;

use super::{Action, World};
use crate::cloth::{Cloth, Rows};

/// The joints of a cloth.
#[derive(Clone)]
pub struct Joints {
    /// Their matrices at the end of the last frame that made a step.
    now: Arc<[Rows]>,
    /// Those at the end of the next one, if the host has moved them.
    next: Option<Arc<[Rows]>>,
    /// Whether they moved in the last frame that made a step.
    moves: bool,
    /// Their matrices at the beginning of that frame and its steps, if they moved.
    way: Option<(Arc<[Rows]>, u32)>,
    /// The particles that follow them while they are pinned, in ascending order: those that are pinned as the cloth comes.
    pub joined: Arc<[u32]>,
}

impl Joints {
    /// Those of a cloth that follows any, as it comes.
    pub fn of(cloth: &Cloth) -> Option<Self> {
        let now = cloth.first_joints()?.clone();
        let pinned = |k: &u32| cloth.particles()[*k as usize].is_pinned();
        let joined = (0..cloth.len() as u32).filter(pinned).collect();
        Some(Joints { now, next: None, moves: false, way: None, joined })
    }

    /// Their matrices at the end of the last frame that made a step.
    pub fn now(&self) -> &[Rows] {
        &self.now
    }

    /// Their matrices at the beginning of the frame that is made, where they move in it, and at its end.
    #[cfg(feature = "gpu")]
    pub fn ends(&self) -> (Option<&[Rows]>, &[Rows]) {
        (self.way.as_ref().map(|way| &way.0[..]), &self.now)
    }

    /// Their matrices at a fraction of the last step: 0 where it began, 1 where it ended. Between them points move in straight lines.
    pub fn at(&self, fraction: f32) -> Vec<Rows> {
        let Some((from, steps)) = self.way.as_ref().filter(|_| fraction < 1.0) else { return self.now.to_vec() };
        let back = (1.0 - fraction) / *steps as f32;
        let one = |(now, from): (&Rows, &Rows)| -> Rows {
            std::array::from_fn(|r| std::array::from_fn(|c| now[r][c] + (from[r][c] - now[r][c]) * back))
        };
        self.now.iter().zip(from.iter()).map(one).collect()
    }

    /// The same of another image of the cloth, of which these particles follow them.
    pub fn on_level(&self, joined: Arc<[u32]>) -> Self {
        Joints { joined, ..self.clone() }
    }

    /// The matrices, moved by a rigid transform whose columns are given.
    fn moved(&self, by: &[[f32; 4]; 4]) -> Arc<[Rows]> {
        let row = |m: &Rows, r: usize| -> [f32; 4] {
            std::array::from_fn(|c| {
                let turned = (0..3).map(|k| f64::from(by[k][r]) * f64::from(m[k][c])).sum::<f64>();
                (turned + if c == 3 { f64::from(by[3][r]) } else { 0.0 }) as f32
            })
        };
        self.now.iter().map(|m| [0, 1, 2].map(|r| row(m, r))).collect()
    }
}

impl World {
    /// Moves the joints of a cloth in the next frame that makes a step; not where it follows none.
    pub fn move_joints(&mut self, cloth: usize, rows: Arc<[Rows]>) {
        let Some(joints) = &mut self.runs[cloth].joints else { return };
        if joints.next.as_ref().unwrap_or(&joints.now) != &rows {
            joints.next = Some(rows);
            self.wake(cloth);
        }
    }

    /// The action after which the targets of a cloth are those of its start, or of where its joints are now.
    pub fn aim(&self, cloth: usize) -> Action {
        match &self.runs[cloth].joints {
            Some(joints) => Action::Skin { cloth, from: None, to: joints.now.clone(), rate: 0.0 },
            None => Action::Aim { cloth },
        }
    }

    /// Puts the joints of a cloth somewhere at the start of the next frame, as if they had been there.
    pub fn put_joints(&mut self, cloth: usize, rows: Arc<[Rows]>) {
        let Some(joints) = &mut self.runs[cloth].joints else { return };
        (joints.now, joints.next, joints.moves, joints.way) = (rows.clone(), None, false, None);
        self.host.actions.push(Action::Skin { cloth, from: None, to: rows, rate: 0.0 });
        self.wake(cloth);
    }

    /// Moves the joints of a cloth as a teleport moves the cloth. Where they go in the next frame is the host's to say.
    pub fn teleport_joints(&mut self, cloth: usize, by: &[[f32; 4]; 4]) {
        let Some(joints) = &mut self.runs[cloth].joints else { return };
        (joints.now, joints.way) = (joints.moved(by), None);
        let to = joints.now.clone();
        self.host.actions.push(Action::Skin { cloth, from: None, to, rate: 0.0 });
    }

    /// Begins a frame of a number of steps: joints that the host has moved are on their way in it, and those that it has not moved rest.
    pub fn lead(&mut self, steps: u32) {
        if steps == 0 {
            return;
        }
        let rate = 1.0 / (f64::from(steps) * self.control.clock.dt);
        for (cloth, run) in self.runs.iter_mut().enumerate() {
            let Some(joints) = &mut run.joints else { continue };
            let moved = std::mem::replace(&mut joints.moves, joints.next.is_some());
            joints.way = None;
            if let Some(to) = joints.next.take() {
                let from = Some(std::mem::replace(&mut joints.now, to.clone()));
                joints.way = from.clone().map(|from| (from, steps));
                self.host.actions.push(Action::Skin { cloth, from, to, rate: rate as f32 });
            } else if moved {
                self.host.actions.push(Action::Skin { cloth, from: None, to: joints.now.clone(), rate: 0.0 });
            }
        }
    }

    /// Whether the joints of any cloth move in this frame.
    pub fn leads(&self) -> bool {
        self.runs.iter().any(|run| run.joints.as_ref().is_some_and(|joints| joints.moves))
    }
}
