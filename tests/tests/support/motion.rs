//! The joints of a character file over time, as `gimage simulate` moves them: first from the pose of the file into the animation.

use std::path::Path;

use gimage::import::{Character, ImportOptions};
use gimage_runtime::Cloth;

/// Seconds in which a character goes from the pose of its file into the animation.
pub const LEAD: f64 = 1.0;

/// The joints of a cloth over time.
pub struct Motion {
    pub character: Character,
    nodes: Vec<usize>,
}

impl Motion {
    pub fn new(file: &Path, cloth: &Cloth, animation: &str) -> Self {
        let character = Character::read(file, animation, &ImportOptions::default()).unwrap();
        let joints = cloth.skin().unwrap().joints();
        Motion { nodes: joints.iter().map(|j| character.node(&j.name).unwrap()).collect(), character }
    }

    pub fn worlds(&self, time: f64) -> Vec<[f64; 16]> {
        let share = ((time + LEAD) / (0.7 * LEAD)).clamp(0.0, 1.0);
        self.character.worlds_between(time, share * share * (3.0 - 2.0 * share))
    }

    pub fn matrices(&self, cloth: &Cloth, time: f64) -> Vec<[f32; 16]> {
        let worlds = self.worlds(time);
        let joints: Vec<_> = self.nodes.iter().map(|n| worlds[*n].map(|x| x as f32)).collect();
        cloth.skin().unwrap().matrices(&joints).unwrap()
    }
}
