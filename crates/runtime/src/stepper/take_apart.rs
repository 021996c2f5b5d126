//! Takes cloths apart that cross at the start of a scene, before anything steps it.
//!
//! The CPU backend takes crossing cloth apart while it moves ([`crate::ClothContact`]); the GPU backend does not. So the cloths that cross make some frames
//! on the CPU first, without gravity and wind, and start where these end.

use std::fmt;

use super::Stepper;
use crate::cloth::Cloth;
use crate::collider::Collider;
use crate::crossings::{self, Drawn};
use crate::error::Result;
use crate::options::{Backend, Options, Solver};
use crate::quality::Quality;
use crate::scene::Scene;

/// Most frames of 1/60 s.
const MOST_FRAMES: u32 = 90;
/// Frames after which crossings are counted again.
const COUNT_FRAMES: u32 = 5;
/// Damping \[1/s\], so that springs that give way throw nothing.
const DAMPING: f32 = 20.0;
/// Most pairs that are looked through for the cloths that cross.
const MOST_PAIRS: u64 = 1 << 20;

/// Result of [`Scene::take_apart`].
#[derive(Clone, Debug, PartialEq)]
pub struct TakenApart {
    /// The cloths that crossed themselves or one another, by name.
    pub cloths: Vec<String>,
    /// Pairs of triangles that crossed, and those that still do.
    pub pairs: u64,
    /// See `pairs`.
    pub left: u64,
    /// Frames of 1/60 s that were made.
    pub frames: u32,
    /// The longest way of a particle \[m\].
    pub farthest: f64,
}

impl fmt::Display for TakenApart {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let TakenApart { cloths, pairs, left, frames, farthest } = self;
        let (names, s) = (cloths.join(", "), if cloths.len() == 1 { "" } else { "s" });
        write!(f, "cloth{s} {names}: {pairs} pairs of triangles cross at the start; ")?;
        match left {
            0 => write!(f, "taken apart in {frames} frames, {:.0} mm at most", 1e3 * farthest),
            _ => write!(f, "{left} are left after {frames} frames that were to take them apart"),
        }
    }
}

impl Scene {
    /// Takes cloths apart that cross themselves or one another at the start, if they have [`Cloth::contact`]: layers that overlap, a sleeve in a side.
    /// Those that cross make up to 90 frames of 1/60 s on the CPU backend, without gravity, wind and motion of colliders and joints, in which contact takes
    /// them apart; their positions at the start ([`Cloth::positions`]) become those of the end. Rest lengths, pins and joints stay. `None`, and
    /// not a bit changes, where nothing crosses, where no cloth has contact, and with [`Solver::Classic`], which has none. If more pairs cross in the end,
    /// all cloths stay as they are.
    ///
    /// [`Stepper::new`] calls it for the GPU backend, and reports it as a warning. The CPU backend does without it. Deterministic. Takes as long as
    /// [`crossings::find`] where nothing crosses, else as the frames do on the CPU. Errors as [`Scene::check`], and if memory is short for the
    /// search.
    ///
    /// ```
    /// use gimage_runtime::{ClothContact, Flat, Options, Scene};
    ///
    /// let mut scene = Scene::new("two sheets");
    /// for (name, right) in [("flat", [1.0, 0.0, 0.0]), ("tilted", [1.0, 0.2, 0.0])] {
    ///     let mut cloth = Flat { origin: [-0.5, -0.5 * right[1] + 0.03, 0.01], right, ..Flat::square(name, 17) }.cloth()?;
    ///     cloth.contact = Some(ClothContact::default());
    ///     scene.cloths.push(cloth);
    /// }
    /// let Some(taken) = scene.take_apart(&Options::default())? else { panic!("they cross") };
    /// assert!(taken.pairs > 20 && taken.left == 0, "{taken}");
    /// assert_eq!(scene.take_apart(&Options::default())?, None);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn take_apart(&mut self, options: &Options) -> Result<Option<TakenApart>> {
        self.check()?;
        let meet: Vec<usize> = (0..self.cloths.len()).filter(|c| self.cloths[*c].contact.is_some()).collect();
        if meet.is_empty() || options.solver == Solver::Classic {
            return Ok(None);
        }
        let drawn: Vec<Drawn> = meet.iter().map(|c| Drawn::new(&self.cloths[*c])).collect();
        let pairs = crossings::find(&drawn, 0)?.total();
        if pairs == 0 {
            return Ok(None);
        }
        let found = crossings::find(&drawn, pairs.min(MOST_PAIRS) as usize)?;
        let mut crossing: Vec<usize> =
            found.worst.iter().flat_map(|pair| [pair.first.cloth, pair.second.cloth]).map(|at| meet[at]).collect();
        crossing.sort_unstable();
        crossing.dedup();
        let (ends, frames) = self.ends(&crossing, options)?;
        let at = |c: &usize| crossing.iter().position(|of| of == c).map(|n| &ends[n][..]);
        let drawn: Vec<Drawn> =
            meet.iter().map(|c| Drawn { positions: at(c), ..Drawn::new(&self.cloths[*c]) }).collect();
        let left = crossings::find(&drawn, 0)?.total();
        let cloths = crossing.iter().map(|c| self.cloths[*c].name().to_owned()).collect();
        let mut taken = TakenApart { cloths, pairs, left: left.min(pairs), frames, farthest: 0.0 };
        if left < pairs {
            for (cloth, end) in crossing.iter().zip(ends) {
                taken.farthest = taken.farthest.max(farthest(&self.cloths[*cloth], &end));
                self.cloths[*cloth].place(end.into_iter().map(|[x, y, z, _]| [x, y, z]).collect())?;
            }
        }
        Ok(Some(taken))
    }

    /// Where the particles of some cloths are once contact has taken these apart, and the number of frames for that.
    fn ends(&self, crossing: &[usize], options: &Options) -> Result<(Vec<Vec<[f32; 4]>>, u32)> {
        let calm = |c: &usize| {
            let mut cloth = self.cloths[*c].clone();
            (cloth.damping, cloth.velocity) = (cloth.damping.max(DAMPING), [0.0; 3]);
            cloth
        };
        let still = |c: &Collider| Collider { velocity: [0.0; 3], spin: [0.0; 3], ..*c };
        let scene = Scene {
            cloths: crossing.iter().map(calm).collect(),
            colliders: self.colliders.iter().map(still).collect(),
            gravity: [0.0; 3],
            wind: None,
            ..Scene::new(&self.name)
        };
        let (quality, backend, sleep, normals) = (Quality::Fixed, Backend::Cpu, None, false);
        let options = Options { quality, backend, sleep, normals, ..options.clone() };
        let mut stepper = Stepper::on_cpu(scene, options)?;
        for frame in 1..=MOST_FRAMES {
            stepper.advance(1.0 / 60.0)?;
            if frame % COUNT_FRAMES == 0 && stepper.crossings()? == 0 {
                return Ok((stepper.all_positions(), frame));
            }
        }
        Ok((stepper.all_positions(), MOST_FRAMES))
    }
}

impl Stepper {
    /// Pairs of triangles that cross, on the CPU backend.
    fn crossings(&self) -> Result<u64> {
        let cloths = self.scene().cloths.iter().enumerate();
        let drawn: Vec<Drawn> =
            cloths.map(|(c, cloth)| Drawn { positions: self.positions(c), ..Drawn::new(cloth) }).collect();
        Ok(crossings::find(&drawn, 0)?.total())
    }

    fn all_positions(&self) -> Vec<Vec<[f32; 4]>> {
        (0..self.scene().cloths.len()).map(|c| self.positions(c).unwrap_or(&[]).to_vec()).collect()
    }
}

/// The longest way of a particle from the start of a cloth \[m\].
fn farthest(cloth: &Cloth, ends: &[[f32; 4]]) -> f64 {
    let way =
        |(from, to): (&[f32; 3], &[f32; 4])| (0..3).map(|c| f64::from(to[c] - from[c]).powi(2)).sum::<f64>().sqrt();
    cloth.positions().iter().zip(ends).map(way).fold(0.0, f64::max)
}
