//! Decides which side of a contour is wrong.
//!
//! Between cloths of different layers the higher one belongs in front of the lower one. Otherwise a contour divides a sheet into the part in front of
//! the other sheet and the part behind it, and the part with fewer points is wrong, of both sheets. A part with points that do not move
//! is wrong only if all parts have some. A contour that ends inside a sheet separates nothing of it if both parts grow far around it, or to points
//! that do not move.

use super::Untangle;
use super::contour::Contour;
use super::pierce::Hit;

/// How many times as many points a part must have that is right if a way leads around the contour.
const CLEAR_RATIO: f64 = 1.25;
/// Points of a part that a contour with an end may separate: this many, and for each square of as many edges as pierce a face along it. It goes
/// around the end of a short one in large sheets else, and comes to no verdict after all of their points.
const FAR: [usize; 2] = [64, 4];

/// Which sheet of a contour is on the wrong side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    pub sheet: usize,
    /// Whether its wrong part lies in front of the other sheet.
    pub in_front: bool,
}

/// Memory of searches, used again: who came to each point last.
pub struct Flood {
    seen: Vec<u32>,
    last: u32,
    /// Edges that pierce a face: no way leads along them.
    closed: Vec<bool>,
}

impl Flood {
    /// That of a surface with these hits.
    pub fn new(of: &Untangle, hits: &[Hit]) -> Self {
        let mut closed = vec![false; of.net.edges.len()];
        hits.iter().for_each(|hit| closed[hit.edge as usize] = true);
        Flood { seen: vec![0; of.at.len()], last: 0, closed }
    }

    /// Starts a search of `searches` floods; the number before that of the first one.
    pub fn start(&mut self, searches: u32) -> u32 {
        let before = self.last;
        self.last += searches;
        before
    }

    /// Comes to a point; false if the flood was there.
    pub fn enter(&mut self, point: u32, flood: u32) -> bool {
        let seen = &mut self.seen[point as usize];
        std::mem::replace(seen, flood) != flood
    }

    /// Who came to a point last.
    fn owner(&self, point: u32) -> u32 {
        self.seen[point as usize]
    }

    /// Whether a search came to a point.
    #[cfg(test)]
    pub fn is_seen(&self, point: u32) -> bool {
        self.owner(point) > 0
    }

    /// Whether a way leads along an edge.
    pub fn is_open(&self, edge: u32) -> bool {
        !self.closed[edge as usize]
    }
}

/// The smaller part of a sheet. Parts are compared in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    /// Whether it has points that do not move.
    pinned: bool,
    /// Whether a way leads to the other part, around an end of the contour.
    open: bool,
    /// Number of points.
    size: usize,
    in_front: bool,
    /// Whether the other part has clearly more points.
    clear: bool,
}

/// The verdict on a contour; none if it does not separate a sheet clearly.
pub fn verdict(of: &Untangle, flood: &mut Flood, hits: &[Hit], contour: &Contour) -> Option<Verdict> {
    if let Some(verdict) = by_layers(of, hits, contour) {
        return Some(verdict);
    }
    let parts = [0, 1].map(|sheet| smaller_part(of, flood, hits, &contour.hits[sheet]));
    let each = parts.into_iter().enumerate().filter_map(|(sheet, part)| part.map(|part| (part, sheet)));
    let (part, sheet) = each.min()?;
    (part.clear || !part.open).then_some(Verdict { sheet, in_front: part.in_front })
}

/// The verdict if the sheets have different layers: the higher one is not to be behind the lower one.
fn by_layers(of: &Untangle, hits: &[Hit], contour: &Contour) -> Option<Verdict> {
    let layers = |sheet: usize| {
        let hit = hits[*contour.hits[sheet].first()? as usize];
        let of_point = |point: u32| of.layers[point as usize];
        let both = [of_point(of.net.edges[hit.edge as usize][0]), of_point(of.net.faces[hit.face as usize][0])];
        Some(if sheet == 0 { both } else { [both[1], both[0]] })
    };
    let [first, second] = layers(0).or_else(|| layers(1))?;
    (first != second).then_some(Verdict { sheet: usize::from(second > first), in_front: false })
}

/// The smaller of both parts of a sheet; none if no edge of the sheet pierces the other one, or if the contour separates none. It may end inside a
/// sheet, at the border of the other one: then both parts meet around that end, halfway from the contour.
fn smaller_part(of: &Untangle, flood: &mut Flood, hits: &[Hit], on: &[u32]) -> Option<Part> {
    let first = flood.start(2) + 1;
    let mut parts = [Growth::default(), Growth::default()];
    for hit in on.iter().map(|n| hits[*n as usize]) {
        let ends = of.net.edges[hit.edge as usize];
        parts[0].enter(flood, ends[hit.front], [first, first + 1]);
        parts[1].enter(flood, ends[1 - hit.front], [first + 1, first]);
    }
    let far = FAR[0] + FAR[1] * on.len() * on.len();
    let is_lost = |part: &Growth| part.pinned || part.points.len() > far;
    // Both grow by a point each in turn, so that the search takes about as long as the smaller one does.
    loop {
        if parts.iter().any(|part| part.open) && parts.iter().all(is_lost) {
            return None;
        }
        if parts.iter().any(|part| part.is_complete() && !part.pinned) || parts.iter().all(Growth::is_complete) {
            break;
        }
        parts[0].grow(of, flood, [first, first + 1]);
        parts[1].grow(of, flood, [first + 1, first]);
    }
    let rank = |part: &Growth| (part.pinned || !part.is_complete(), part.points.len());
    let smaller = usize::from(rank(&parts[1]) < rank(&parts[0]));
    let enough = (CLEAR_RATIO * parts[smaller].points.len() as f64) as usize + 1;
    while parts[1 - smaller].points.len() < enough && !parts[1 - smaller].is_complete() {
        let numbers = if smaller == 0 { [first + 1, first] } else { [first, first + 1] };
        parts[1 - smaller].grow(of, flood, numbers);
    }
    let clear = parts[1 - smaller].points.len() >= enough || parts[1 - smaller].pinned;
    let part = &parts[smaller];
    let open = parts.iter().any(|part| part.open);
    let size = part.points.len();
    (size > 0).then_some(Part { pinned: part.pinned, open, size, in_front: smaller == 0, clear })
}

/// A part of a sheet that grows from a contour on.
#[derive(Default)]
struct Growth {
    points: Vec<u32>,
    /// Points whose neighbours are known.
    done: usize,
    pinned: bool,
    open: bool,
}

impl Growth {
    fn is_complete(&self) -> bool {
        self.done == self.points.len()
    }

    /// Takes in a point that neither part has; the numbers are those of its own flood and of the other one.
    fn enter(&mut self, flood: &mut Flood, point: u32, [own, other]: [u32; 2]) {
        if flood.owner(point) == other {
            self.open = true;
        } else if flood.enter(point, own) {
            self.points.push(point);
        }
    }

    /// Takes in the neighbours of one of its points.
    fn grow(&mut self, of: &Untangle, flood: &mut Flood, numbers: [u32; 2]) {
        let Some(point) = self.points.get(self.done).copied() else { return };
        self.done += 1;
        self.pinned |= !of.free[point as usize];
        for [next, edge] in of.net.around(point) {
            if flood.is_open(*edge) {
                self.enter(flood, *next, numbers);
            }
        }
    }
}
