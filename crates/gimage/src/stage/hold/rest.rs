//! The rules that find where a garment rests on a body.

use super::sheet::Sheet;
use super::wearer::Wearer;
use crate::base::vec3::{add, distance, norm, scale};

/// A rule by which a garment is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// The highest border lies around the body: a collar, a waistband.
    Ring,
    /// The highest parts, or those beside the highest border, lie on top of the body: shoulders, straps.
    Shoulders,
    /// The upper edge is near the body: a cape.
    Edge,
    /// None of the others: the top of the garment.
    Top,
}

impl Rule {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Rule::Ring => "its highest border around the body",
            Rule::Shoulders => "its parts on top of the body (shoulders, straps)",
            Rule::Edge => "its upper edge on the body",
            Rule::Top => "its top, because no part of it rests on the body",
        }
    }
}

// Lengths, as shares of the height of body and garment together.

/// Distance within which cloth rests on the body: 4.5 cm of a person.
pub(super) const NEAR: f64 = 0.025;
/// Height of the upper part of a garment, in which it may be held.
const WINDOW: f64 = 0.08;
/// The same, as a share of the height of the garment.
const WINDOW_OF_GARMENT: f64 = 0.2;
/// How far the held band goes beyond borders.
const BAND: f64 = 0.01;
/// How far from the highest border a garment lies on shoulders.
const SHOULDERS: f64 = 0.06;
/// How far from the held band limits end.
const REACH: f64 = 0.1;
/// The same, as a share of the height of the garment.
const REACH_OF_GARMENT: f64 = 0.3;
/// Largest height of a border that is a ring, and largest radius of one around a bone.
const RING: f64 = 0.15;
/// Distance of a bone beneath a shoulder.
const BONE: f64 = 0.1;

/// How far a surface faces up where something lies on it: 53 degrees from the vertical.
const UP: f64 = 0.6;
/// Length of the sum of the horizontal normals along a border, as a share of the sum of their lengths, from which the border does not go
/// around anything.
const ONE_SIDED: f64 = 0.6;
/// Height of the highest point of a ring in its garment, as a share of the height of that, at least.
const UPPER: f64 = 0.5;
/// Share of a ring that is near the body.
const TIGHT: f64 = 0.8;
/// Share of what is beside a ring that has to lie on top of the body to be held.
const BORNE: f64 = 0.25;
/// Height of the top of a garment that nothing else holds, as a share of its height.
const TOP: f64 = 0.06;
/// Share of its area above which a garment would be a prop: its top is held instead.
pub(super) const MOST: f64 = 0.5;

/// Where a garment rests.
pub(super) struct Rest {
    /// The rules, in their order.
    pub rules: Vec<Rule>,
    /// The points that are held.
    pub points: Vec<u32>,
    /// How many of them, from the first on, are held where all are too many.
    pub core: usize,
    /// How far beyond them the garment is held \[m\].
    pub band: f64,
    /// The smallest limit of what is not pinned \[m\].
    pub least: f64,
    /// How far beyond that limits end \[m\].
    pub reach: f64,
}

impl Rest {
    /// Holds the ring alone, without a band; nothing if there is none.
    pub fn narrow(&mut self) {
        self.points.truncate(self.core);
        self.rules.truncate(1);
        self.band = 0.0;
    }
}

/// Height of the body and a garment together \[m\].
pub(super) fn height(wearer: &Wearer, [low, high]: [f64; 2]) -> f64 {
    wearer.span[1].max(high) - wearer.span[0].min(low)
}

/// A garment beside the body.
struct Worn<'a> {
    wearer: &'a Wearer,
    sheet: &'a Sheet,
    /// Height of body and garment \[m\].
    height: f64,
    /// Where the window begins \[m\].
    window: f64,
    /// Distance from the body \[m\] of each point in the window, and how far the body faces up there.
    near: Vec<(f64, f64)>,
}

/// Where a garment rests, by the first rules that apply.
pub(super) fn rest(wearer: &Wearer, sheet: &Sheet) -> Rest {
    let [low, high] = sheet.span();
    let height = height(wearer, [low, high]);
    let window = high - (WINDOW * height).min(WINDOW_OF_GARMENT * (high - low));
    let near = |p: &[f64; 3]| if p[1] >= window { wearer.near(*p) } else { (f64::INFINITY, 0.0) };
    let near = sheet.positions.iter().map(near).collect();
    let worn = Worn { wearer, sheet, height, window, near };
    let mut found = Rest {
        rules: Vec::new(),
        points: worn.ring(),
        core: 0,
        band: BAND * height,
        least: NEAR * height,
        reach: reach(height, high - low),
    };
    if !found.points.is_empty() {
        found.rules.push(Rule::Ring);
        found.core = found.points.len();
    }
    let shoulders = worn.shoulders(&found.points);
    if !shoulders.is_empty() {
        found.rules.push(Rule::Shoulders);
        found.points.extend(shoulders);
    }
    if found.points.is_empty() {
        found.points = worn.edge();
        found.rules = vec![Rule::Edge];
    }
    if found.points.is_empty() { Rest { least: found.least, reach: found.reach, ..top(sheet) } } else { found }
}

/// The top of a garment.
pub(super) fn top(sheet: &Sheet) -> Rest {
    let [low, high] = sheet.span();
    let least = high - TOP * (high - low);
    let points = (0..sheet.positions.len() as u32).filter(|p| sheet.positions[*p as usize][1] >= least).collect();
    Rest {
        rules: vec![Rule::Top],
        points,
        core: 0,
        band: 0.0,
        least: NEAR * (high - low),
        reach: REACH_OF_GARMENT * (high - low),
    }
}

fn reach(height: f64, garment: f64) -> f64 {
    (REACH * height).min(REACH_OF_GARMENT * garment)
}

impl Worn<'_> {
    fn y(&self, p: u32) -> f64 {
        self.sheet.positions[p as usize][1]
    }

    /// The points of the highest border, if it goes around the body and is near it.
    fn ring(&self) -> Vec<u32> {
        let mean = |border: &Vec<u32>| border.iter().map(|&p| self.y(p)).sum::<f64>() / border.len() as f64;
        let highest = self.sheet.borders.iter().reduce(|a, b| if mean(b) > mean(a) { b } else { a });
        let Some(border) = highest else { return Vec::new() };
        let of = |f: &dyn Fn(usize) -> [f64; 3]| {
            let sum = border.iter().fold([0.0; 3], |sum, &p| add(sum, f(p as usize)));
            scale(sum, 1.0 / border.len() as f64)
        };
        let highest = border.iter().map(|&p| self.y(p)).fold(f64::NEG_INFINITY, f64::max);
        let lowest = border.iter().map(|&p| self.y(p)).fold(f64::INFINITY, f64::min);
        let across = |p: usize| [self.sheet.normals[p][0], 0.0, self.sheet.normals[p][2]];
        let lengths: f64 = border.iter().map(|&p| norm(across(p as usize))).sum();
        let one_sided = norm(of(&across)) * border.len() as f64 > ONE_SIDED * lengths;
        let [bottom, top] = self.sheet.span();
        // Trousers whose waist is closed have no border above their hems.
        let is_low = highest < bottom + UPPER * (top - bottom);
        if one_sided || is_low || highest - lowest > RING * self.height {
            return Vec::new();
        }
        let near = |p: &&u32| {
            let (far, _) = self.wearer.near(self.sheet.positions[**p as usize]);
            far <= NEAR * self.height
        };
        let center = of(&|p| self.sheet.positions[p]);
        let radius = border.iter().map(|&p| distance(self.sheet.positions[p as usize], center)).sum::<f64>()
            / border.len() as f64;
        let is_tight = border.iter().filter(near).count() as f64 >= TIGHT * border.len() as f64;
        let has_bone = radius <= RING * self.height && self.wearer.to_bone(center, false) <= 0.6 * radius;
        if !(is_tight || has_bone) {
            return Vec::new();
        }
        border.iter().copied().filter(|&p| self.y(p) >= highest - WINDOW * self.height).collect()
    }

    /// Whether a point lies on something that faces up, which may be a bone where the file has no body beneath.
    fn is_borne(&self, p: u32) -> bool {
        let (far, up) = self.near[p as usize];
        if far <= NEAR * self.height {
            return up >= UP;
        }
        let position = self.sheet.positions[p as usize];
        self.y(p) >= self.window
            && self.sheet.normals[p as usize][1] >= UP
            && self.wearer.to_bone(position, true) <= BONE * self.height
    }

    /// Points that lie on top of the body, near `ring`, or near the highest of them; without a ring also the highest points of the garment
    /// that are near the body, such as the neck of a top whose openings have caps.
    fn shoulders(&self, ring: &[u32]) -> Vec<u32> {
        let all = 0..self.sheet.positions.len() as u32;
        let mut borne: Vec<u32> = all.clone().filter(|&p| self.is_borne(p)).collect();
        let top = |points: &[u32]| points.iter().map(|&p| self.y(p)).fold(f64::NEG_INFINITY, f64::max);
        let below = 2.0 * BAND * self.height;
        let least = top(&borne) - below;
        let far = match ring {
            [] => {
                let highest = borne.iter().copied().filter(|&p| self.y(p) >= least);
                self.sheet.distances(highest, SHOULDERS * self.height)
            }
            ring => self.sheet.distances(ring.iter().copied(), SHOULDERS * self.height),
        };
        borne.retain(|&p| far[p as usize].is_finite());
        let area = |points: &mut dyn Iterator<Item = u32>| points.map(|p| self.sheet.areas[p as usize]).sum::<f64>();
        let beside = area(&mut all.clone().filter(|&p| far[p as usize].is_finite()));
        if borne.is_empty() || !ring.is_empty() && area(&mut borne.iter().copied()) < BORNE * beside {
            return Vec::new();
        }
        if ring.is_empty() {
            let least = self.sheet.span()[1] - below;
            borne.extend(all.filter(|&p| self.y(p) >= least && self.is_near(p)));
        }
        borne
    }

    /// Whether the body is near, or a bone where the file has no body.
    fn is_near(&self, p: u32) -> bool {
        let far = |p: [f64; 3]| self.wearer.to_bone(p, false);
        self.near[p as usize].0 <= NEAR * self.height || far(self.sheet.positions[p as usize]) <= BONE * self.height
    }

    /// Points of borders in the window that are near the body.
    fn edge(&self) -> Vec<u32> {
        let near = |p: &u32| self.near[*p as usize].0 <= NEAR * self.height;
        self.sheet.borders.iter().flatten().copied().filter(near).collect()
    }
}
