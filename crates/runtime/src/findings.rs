//! Failures in a run: found while it steps, so that nothing fails in silence.
//!
//! Figures are taken 0.2 s after a cloth's start and then twice per second: at most 20 ns per particle each time, 0.7 ns per frame.
//! Tunnelling shows only from frame to frame. It is looked for in frames in which a particle or a collider moves by half of
//! the thinnest collider's radius; finding out costs 1 ns per particle per frame in scenes with colliders, and the search ([`passing`]) some
//! more. Cloth inside colliders is looked for in its first frame and where cloth or colliders were put elsewhere ([`thrown`]).

pub mod passing;
pub mod thrown;
mod words;

use self::passing::Passing;
use crate::cloth::{Cloth, Grid};
use crate::collider::solid::Solid;
use crate::handle::follow;
use crate::health::{self, Health};
use crate::number::real::{Real, V3, cast, dot, scale, sub, xyz};
use crate::scene::Pose;

/// A failure of a cloth during a run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fate {
    /// Springs are longer than [`MAX_LENGTH`] times their rest length, and that of the mean, or, without compliance, one in a hundred is extended by
    /// more than [`MAX_P99`] after the first second; of a material also by more than its weight would do to a strip 10 cm
    /// wide.
    Stretched {
        /// Largest length / rest length.
        ratio: f64,
        /// 99th percentile of the extension.
        p99: f64,
        /// Whether an end of a spring that is extended most is a pin.
        at_pin: bool,
        /// Two colliders, by index, that press the longest spring from opposite sides, if there are any.
        between: Option<[usize; 2]>,
    },
    /// The cloth touched colliders, and its topmost particle is below all of these: it slid off or went through.
    Left,
    /// No pin holds the cloth, nothing is below it, and it touched nothing; or so falls a piece of it that neither pins nor seams nor stitches hold.
    Falls,
    /// Particles went through a collider within a frame.
    Tunnelled {
        /// Most particles in a frame.
        particles: usize,
        /// One of them.
        particle: usize,
        /// The collider by index.
        collider: usize,
    },
    /// Cloth whose contact is [`crate::ContactTier::Safe`] crosses cloth. Contact takes it apart.
    Crossed {
        /// Pairs of triangles that cross.
        pairs: u64,
        /// Pairs that touch, which contact cannot keep apart.
        touching: u64,
        /// Pins and joints that left cloth no room; 0 if cloth crosses where it starts, or where it was put.
        forced: usize,
    },
    /// Cloth with contact that crosses has not been taken apart for 2 s: pins, joints, colliders or seams keep it so.
    Tangled {
        /// Pairs of triangles that cross.
        pairs: u64,
    },
    /// Contact of this tier held particles back because they are too fast for it.
    Slowed {
        /// Most particles in a step.
        particles: usize,
    },
    /// Contact of the tier `safe` holds particles inside colliders, because the gap between the colliders is smaller than the layers of cloth.
    Squeezed {
        /// Largest depth \[m\].
        depth: f64,
    },
    /// The cloth was inside colliders as a frame began: where it starts, where it was put, or where colliders were put on it. Contact puts it outside
    /// within a step, which gives it the speed of that way. [`crate::Scene::clear_start`] clears a start.
    Thrown {
        /// The collider by index that a particle is deepest in.
        collider: usize,
        /// Its depth \[m\].
        depth: f64,
        /// Mean speed that the cloth gets \[m/s\]: more than 1.
        speed: f64,
    },
}

/// A particle by its place in a piece.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PieceTexel {
    /// The piece of the bundle: the grid by name.
    pub piece: String,
    /// Column and row of its texel.
    pub texel: [u32; 2],
}

/// A failure, where and when it was found; one of each kind per cloth, with the worst figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The cloth by its index now. Findings of a removed cloth are dropped.
    pub cloth: usize,
    /// The cloth by name.
    pub name: String,
    /// Where the longest spring begins ([`Fate::Stretched`]), a particle that went through ([`Fate::Tunnelled`]), or the deepest one ([`Fate::Thrown`]); at the time of the worst figures.
    pub place: Option<PieceTexel>,
    /// When it was first found \[s\], in the time of the scene.
    pub time: f64,
    /// The failure.
    pub fate: Fate,
    /// Substeps at that time.
    pub substeps: u32,
}

/// Length / rest length of a spring beyond which cloth counts as torn out of shape; of a spring shorter than the mean, length / mean rest length.
pub const MAX_LENGTH: f64 = 3.0;
/// Extension that one spring in a hundred may have.
pub const MAX_P99: f64 = 0.1;
/// Width of a strip of fabric \[m\] that a whole garment may hang from.
const STRIP_M: f64 = 0.1;
/// First time of taking figures \[s\], and time between them.
const FIRST_S: f64 = 0.2;
const EVERY_S: f64 = 0.5;
/// Time \[s\] from which one spring in a hundred may not be extended by more than [`MAX_P99`].
const SETTLED_S: f64 = 1.0 - 1e-6;
/// A cloth this close \[m\] to a collider touches it.
const TOUCH_M: f64 = 0.01;
/// Share of a collider's radius: a particle that moves less in a frame cannot pass it, and one that passes the core of
/// this share went through.
const CORE: f64 = 0.5;

/// Figures of one cloth so far.
#[derive(Clone, Debug, Default)]
struct Record {
    /// When the cloth came \[s\].
    start: f64,
    health: Health,
    /// Largest 99th percentile.
    worst: f64,
    touched: Vec<bool>,
    /// Whether it, or colliders, may have been put elsewhere since its last frame.
    is_put: bool,
}

/// Watches the cloths of a scene.
#[derive(Clone, Debug)]
pub struct Watchdog {
    /// When figures are next taken \[s\].
    pub due: f64,
    records: Vec<Record>,
    pub findings: Vec<Finding>,
}

/// A cloth at the end of a frame.
pub struct Sight<'a, T: Real> {
    pub index: usize,
    pub cloth: &'a Cloth,
    /// Where teleports have moved its start.
    pub home: Pose,
    pub now: &'a [[T; 4]],
    pub before: &'a [[T; 4]],
    /// The colliders as the cloth meets them.
    pub solids: &'a [Solid<T>],
    pub gravity: [f32; 3],
    /// End of the frame \[s\], and length of a step.
    pub time: f64,
    pub dt: f64,
    pub substeps: u32,
}

impl Watchdog {
    pub fn new(cloths: usize) -> Self {
        Watchdog {
            due: FIRST_S,
            records: vec![Record { is_put: true, ..Record::default() }; cloths],
            findings: Vec::new(),
        }
    }

    /// Watches a further cloth, which comes at `time` \[s\].
    pub fn join(&mut self, time: f64) {
        self.records.push(Record { start: time, is_put: true, ..Record::default() });
    }

    /// To be called when cloth or colliders have been put elsewhere, without a way.
    pub fn put(&mut self) {
        self.records.iter_mut().for_each(|record| record.is_put = true);
    }

    /// Whether a cloth may begin its next frame inside colliders; not asked again until something is put.
    pub fn take_put(&mut self, cloth: usize) -> bool {
        self.records.get_mut(cloth).is_some_and(|record| std::mem::take(&mut record.is_put))
    }

    /// Whether a cloth comes at `time` \[s\].
    #[cfg(feature = "gpu")]
    pub fn comes(&self, cloth: usize, time: f64) -> bool {
        self.records.get(cloth).is_some_and(|record| record.start == time)
    }

    /// Forgets a cloth and its findings.
    pub fn leave(&mut self, cloth: usize) {
        self.records.remove(cloth);
        self.findings.retain_mut(|finding| follow(&mut finding.cloth, cloth));
    }

    /// Whether a cloth has been there long enough for its figures at `time` \[s\].
    pub fn knows(&self, cloth: usize, time: f64) -> bool {
        self.records.get(cloth).is_some_and(|r| time - r.start >= FIRST_S - 1e-6)
    }

    /// Whether figures are due at the end of a frame.
    pub fn is_due(&self, time: f64) -> bool {
        time >= self.due - 1e-6
    }

    /// To be called when the figures of all cloths have been taken.
    pub fn done(&mut self, time: f64) {
        self.due = (time / EVERY_S + 1e-6).floor() * EVERY_S + EVERY_S;
    }

    /// The last figures of a cloth, and the largest 99th percentile of its extension so far.
    pub fn of(&self, cloth: usize) -> Option<(Health, f64)> {
        self.records.get(cloth).map(|r| (r.health, r.worst))
    }

    /// Takes the figures of a cloth.
    pub fn examine<T: Real>(&mut self, sight: &Sight<T>) {
        let Sight { cloth, now, before, solids, .. } = *sight;
        let stretch = health::stretch(cloth, now);
        let record = &mut self.records[sight.index];
        let start = record.start;
        record.touched.resize(solids.len(), false);
        let near = health::depths(now, solids, TOUCH_M);
        record.touched.iter_mut().zip(&near).for_each(|(touched, depth)| *touched |= *depth > 0.0);
        let depth = near.iter().map(|d| (d - TOUCH_M).max(0.0)).fold(0.0, f64::max);
        record.health = Health { time: sight.time, stretch, speed: health::speed(now, before, sight.dt), depth };
        record.worst = record.worst.max(stretch.map_or(0.0, |s| s.p99));
        let gone = gone(sight, &record.touched);
        if let Some(s) = stretch {
            // Starts are abrupt.
            let rubber = s.p99 > largest(cloth, sight.gravity) && sight.time - start > SETTLED_S;
            if rubber || s.max + 1.0 > MAX_LENGTH {
                let longest = health::longest(cloth, now);
                if rubber || longest.length > MAX_LENGTH {
                    let ends = longest.ends.map(|k| xyz(now[k]));
                    let fate = Fate::Stretched {
                        ratio: s.max + 1.0,
                        p99: s.p99,
                        at_pin: longest.is_at_pin,
                        between: health::between(&ends, solids, TOUCH_M),
                    };
                    self.find_at(sight, fate, Some(longest.ends[0]));
                }
            }
        }
        if let Some(fate) = gone {
            self.find(sight, fate);
        }
        if let Some(particle) = fallen(sight) {
            self.find_at(sight, Fate::Falls, Some(particle));
        }
    }

    /// Takes in which particles went through colliders in the frame.
    pub fn cross<T: Real>(&mut self, sight: &Sight<T>, passings: &[Passing]) {
        for Passing { collider, particles, particle } in passings.iter().copied() {
            self.find_at(sight, Fate::Tunnelled { particles, particle, collider }, Some(particle));
        }
    }

    /// Takes in that a cloth was inside colliders.
    pub fn throw<T: Real>(&mut self, sight: &Sight<T>, thrown: Option<(Fate, usize)>) {
        if let Some((fate, particle)) = thrown {
            self.find_at(sight, fate, Some(particle));
        }
    }

    /// Takes in a failure of a cloth.
    pub fn find<T: Real>(&mut self, sight: &Sight<T>, fate: Fate) {
        self.find_at(sight, fate, None);
    }

    /// The same, with the particle where it is worst.
    fn find_at<T: Real>(&mut self, sight: &Sight<T>, fate: Fate, particle: Option<usize>) {
        let place = particle.and_then(|particle| piece_texel(sight.cloth, particle));
        let same = |f: &&mut Finding| {
            f.cloth == sight.index && std::mem::discriminant(&f.fate) == std::mem::discriminant(&fate)
        };
        match self.findings.iter_mut().find(same) {
            Some(known) => {
                if worse(&fate, &known.fate) {
                    (known.fate, known.place) = (fate, place);
                }
            }
            None => self.findings.push(Finding {
                cloth: sight.index,
                name: sight.cloth.name().into(),
                place,
                time: sight.time,
                fate,
                substeps: sight.substeps,
            }),
        }
    }
}

/// Where a particle is.
fn piece_texel(cloth: &Cloth, particle: usize) -> Option<PieceTexel> {
    let grid = cloth.grids().iter().find(|grid| grid.range().contains(&particle))?;
    let texel = particle as u32 - grid.first;
    Some(PieceTexel { piece: grid.name.clone(), texel: [texel % grid.width, texel / grid.width] })
}

/// Extension that one spring in a hundred may have: any where compliance of springs asks for it.
fn largest(cloth: &Cloth, gravity: [f32; 3]) -> f64 {
    let Some(membrane) = cloth.membrane() else {
        return if crate::choose::stiff(cloth) { MAX_P99 } else { f64::INFINITY };
    };
    let mass: f64 = (0..cloth.len()).map(|k| f64::from(cloth.mass(k))).sum();
    let strength = gravity.iter().map(|g| f64::from(*g).powi(2)).sum::<f64>().sqrt();
    let give = f64::from(membrane.soft[0].max(membrane.soft[1]));
    MAX_P99.max(mass * strength * give / STRIP_M)
}

fn worse(a: &Fate, b: &Fate) -> bool {
    match (a, b) {
        (Fate::Stretched { p99: a, .. }, Fate::Stretched { p99: b, .. }) => a > b,
        (Fate::Tunnelled { particles: a, .. }, Fate::Tunnelled { particles: b, .. }) => a > b,
        (Fate::Crossed { pairs: a, .. }, Fate::Crossed { pairs: b, .. }) => a > b,
        (Fate::Tangled { pairs: a }, Fate::Tangled { pairs: b }) => a > b,
        (Fate::Slowed { particles: a }, Fate::Slowed { particles: b }) => a > b,
        (Fate::Squeezed { depth: a }, Fate::Squeezed { depth: b }) => a > b,
        (Fate::Thrown { speed: a, .. }, Fate::Thrown { speed: b, .. }) => a > b,
        _ => false,
    }
}

/// Whether a cloth without pins is below everything that could hold it.
fn gone<T: Real>(sight: &Sight<T>, touched: &[bool]) -> Option<Fate> {
    let up = up(sight.gravity).filter(|_| sight.now.iter().all(|p| p[3].get() != 0.0))?;
    let height = |p: V3<T>| dot(p, up).get();
    let top = sight.now.iter().filter(|p| p[3].get() >= 0.0).map(|p| height(xyz(*p))).fold(f64::NEG_INFINITY, f64::max);
    let bottom = |s: &Solid<T>| s.around().map_or(f64::NEG_INFINITY, |r| height(s.center) - r.get());
    let lowest = |all: &mut dyn Iterator<Item = f64>| all.fold(f64::INFINITY, f64::min);
    let touches = touched.contains(&true);
    let held = sight.solids.iter().zip(touched).filter(|(_, t)| **t || !touches).map(|(s, _)| bottom(s));
    let start = sight.cloth.positions().iter().map(|p| height(cast(sight.home.apply(*p))));
    let floor = lowest(&mut held.into_iter());
    match touches {
        true => (top < floor).then_some(Fate::Left),
        false => (top < floor.min(lowest(&mut start.into_iter()) - 1.0)).then_some(Fate::Falls),
    }
}

/// The direction against gravity; `None` without any.
fn up<T: Real>(gravity: [f32; 3]) -> Option<V3<T>> {
    let g = gravity.map(|x| T::of(x.into()));
    let strength = dot(g, g).sqrt();
    (strength.get() > 0.0).then(|| scale(g, T::of(-1.0) / strength))
}

/// A particle of a piece of pinned cloth that nothing holds, once all of the piece is below everything that could hold it.
fn fallen<T: Real>(sight: &Sight<T>) -> Option<usize> {
    let up = up(sight.gravity).filter(|_| sight.cloth.grids().len() > 1)?;
    let height = |p: V3<T>| dot(p, up).get();
    let bottoms = sight.solids.iter().map(|s| height(s.center) - s.around().map_or(f64::INFINITY, Real::get));
    let start = sight.cloth.positions().iter().map(|p| height(cast(sight.home.apply(*p))));
    let floor = bottoms.chain(start).fold(f64::INFINITY, f64::min) - 1.0;
    let is_below = |grid: &&Grid| {
        let mut all = sight.now[grid.range()].iter().filter(|p| p[3].get() >= 0.0);
        all.all(|p| height(xyz(*p)) < floor)
    };
    let loose = sight.cloth.loose_grids();
    let below = loose.into_iter().filter_map(|grid| sight.cloth.grids().get(grid)).find(is_below)?;
    below.range().find(|k| sight.now[*k][3].get() >= 0.0)
}

/// Whether something moves so far in a frame of `frame` seconds that it may pass a collider.
pub fn is_risky<T: Real>(now: &[[T; 4]], before: &[[T; 4]], solids: &[Solid<T>], dt: f64, frame: f64) -> bool {
    let thinnest = solids.iter().map(|s| s.thickness().get()).fold(f64::INFINITY, f64::min);
    let length = |v: V3<T>| dot(v, v).sqrt().get();
    let moves = solids.iter().map(|s| length(s.velocity) + length(s.spin) * s.around().map_or(0.0, Real::get));
    let room = CORE * thinnest - moves.fold(0.0, f64::max) * frame;
    if room <= 0.0 {
        return true;
    }
    let limit = T::of((room * dt / frame).powi(2));
    now.iter().zip(before).any(|(a, b)| {
        let d = sub(xyz(*a), xyz(*b));
        dot(d, d) > limit && a[3].get() > 0.0
    })
}
