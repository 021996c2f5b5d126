//! Labels of each point of the surface: its records of the pins nearest to it.

use super::Anchor;

/// Pins of one group that a particle keeps. The line from a pin to where it is the nearest may pass between two particles
/// one of which is nearer to the next pin; without a label of the pin there the path would have to follow edges.
pub(super) const PINS_OF_A_GROUP: usize = 3;

/// A label that gets better by less than this share of its distance does not spread again.
const GAIN: f64 = 1e-12;

/// Waves that go on from one point until a gain must be larger; other surfaces keep their bits. Where cells are squeezed to needles, waves
/// that run around one another get shorter by ever less, without end. From there on the least gain doubles with every `PATIENCE` waves, so
/// that it is the whole distance after 40 times as many; distances stay too long by less than the gain.
const WAVES: u32 = 256;
const PATIENCE: u32 = 8;

/// How far one pin is from one point.
#[derive(Clone, Copy)]
pub(super) struct Label {
    pub distance: f64,
    /// Index of the pin; `u32::MAX` for an empty slot.
    pub pin: u32,
    pub group: u32,
    /// Its wave has gone on from here.
    pub spread: bool,
}

const EMPTY: Label = Label { distance: f64::INFINITY, pin: u32::MAX, group: u32::MAX, spread: false };

/// The labels of all points.
pub(super) struct Labels {
    /// Most groups a point keeps, and most pins of each.
    groups: usize,
    pins: usize,
    labels: Vec<Label>,
    /// How many waves have gone on from each point.
    waves: Vec<u32>,
}

impl Labels {
    pub fn new(points: usize, groups: usize, pins: usize) -> Self {
        Labels { groups, pins, labels: vec![EMPTY; points * groups * pins], waves: vec![0; points] }
    }

    /// The label of a pin at a point; infinitely far if there is none.
    pub fn of(&self, point: u32, pin: u32) -> Label {
        let (start, slots) = self.range(point);
        self.labels[start..start + slots].iter().find(|l| l.pin == pin).copied().unwrap_or(EMPTY)
    }

    pub fn of_mut(&mut self, point: u32, pin: u32) -> Option<&mut Label> {
        let (start, slots) = self.range(point);
        self.labels[start..start + slots].iter_mut().find(|l| l.pin == pin)
    }

    /// Counts a wave that goes on from a point.
    pub fn count(&mut self, point: u32) {
        self.waves[point as usize] += 1;
    }

    /// The share of its distance by which a label at a point has to get better.
    fn gain(&self, point: u32) -> f64 {
        let more = self.waves[point as usize].saturating_sub(WAVES) / PATIENCE;
        (GAIN * 2f64.powi(more.min(64) as i32)).min(1.0)
    }

    /// The nearest pin of each group kept, nearest first.
    pub fn nearest(&self, point: u32) -> Vec<Anchor> {
        let (start, slots) = self.range(point);
        let mut labels = self.labels[start..start + slots].to_vec();
        labels.retain(|l| l.pin != u32::MAX);
        labels.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.pin.cmp(&b.pin)));
        let mut anchors: Vec<(u32, Anchor)> = Vec::new();
        for l in labels {
            if anchors.iter().all(|(group, _)| *group != l.group) {
                anchors.push((l.group, Anchor { particle: l.pin, distance: l.distance as f32 }));
            }
        }
        anchors.into_iter().map(|(_, anchor)| anchor).collect()
    }

    /// Keeps a label if it is among the nearest, and returns whether it did. Ties go to the lower pin, so that the order of offers does
    /// not matter.
    pub fn offer(&mut self, point: u32, new: Label) -> bool {
        let (start, slots) = self.range(point);
        let gain = self.gain(point);
        // Those in the place of others get better too.
        let gains = |new: &Label, old: &Label| gain <= GAIN || new.distance < old.distance * (1.0 - gain);
        let labels = &mut self.labels[start..start + slots];
        let before = |a: &Label, b: &Label| (a.distance, a.pin) < (b.distance, b.pin);
        if let Some(old) = labels.iter_mut().find(|l| l.pin == new.pin) {
            if new.distance >= old.distance * (1.0 - gain) {
                return false;
            }
            *old = new;
        } else {
            let of_group = labels.iter().filter(|l| l.group == new.group).count();
            if of_group == 0 {
                // The nearest label of each group; the farthest of them is the group to give up.
                let leads =
                    |l: &&Label| l.pin != u32::MAX && !labels.iter().any(|m| m.group == l.group && before(m, l));
                let (mut count, mut worst) = (0, EMPTY);
                for l in labels.iter().filter(leads) {
                    count += 1;
                    worst = if worst.pin == u32::MAX || before(&worst, l) { *l } else { worst };
                }
                if count >= self.groups {
                    if before(&worst, &new) || !gains(&new, &worst) {
                        return false;
                    }
                    labels.iter_mut().filter(|l| l.group == worst.group).for_each(|l| *l = EMPTY);
                }
            } else if of_group >= self.pins {
                let group = labels.iter_mut().filter(|l| l.group == new.group);
                let Some(worst) = group.reduce(|a, b| if before(a, b) { b } else { a }) else { return false };
                if !before(&new, worst) || !gains(&new, worst) {
                    return false;
                }
                *worst = EMPTY;
            }
            let Some(free) = labels.iter_mut().find(|l| l.pin == u32::MAX) else { return false };
            *free = new;
        }
        true
    }

    /// Where the labels of a point begin, and how many there are.
    fn range(&self, point: u32) -> (usize, usize) {
        let slots = self.groups * self.pins;
        (point as usize * slots, slots)
    }
}
