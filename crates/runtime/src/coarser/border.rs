//! Which texels of the borders of its grids a coarser image keeps.

use std::collections::BTreeMap;

use crate::cloth::{Cloth, Grid};

/// Texels kept of each side of a grid, in ascending order: columns of the first and of the last row, rows of the first and of the
/// last column. Opposite sides keep the same number.
pub type Sides = [Vec<u32>; 4];

/// Texels of a side.
fn length(grid: &Grid, side: usize) -> u32 {
    if side < 2 { grid.width } else { grid.height }
}

/// The particle at a place of a side.
fn particle(grid: &Grid, side: usize, place: u32) -> usize {
    let (w, h) = (grid.width, grid.height);
    let local = match side {
        0 => place,
        1 => (h - 1) * w + place,
        2 => place * w,
        _ => place * w + w - 1,
    };
    (grid.first + local) as usize
}

/// Thins the points of all borders. A point is all duplicates of a seam texel, which are kept or left out together.
struct Thinning<'a> {
    grids: &'a [Grid],
    /// The point of each particle, by its first duplicate.
    points: Vec<u32>,
    /// Grid, side and place of each point on a border. A corner is on two sides.
    places: BTreeMap<u32, Vec<(usize, usize, u32)>>,
    left_out: Vec<bool>,
    stays: Vec<bool>,
}

/// How much more the first side of a grid has than the opposite one, by grid and pair of sides.
type Excess = BTreeMap<(usize, usize), i64>;

/// The texels that each side of each grid keeps: corners, and about every other texel between them. `None` where opposite sides cannot keep
/// the same number.
pub fn sides(cloth: &Cloth) -> Option<Vec<Sides>> {
    let mut thinning = Thinning::new(cloth);
    thinning.thin();
    thinning.balance()?;
    let kept = |g: usize, side: usize| {
        let grid = &cloth.grids()[g];
        (0..length(grid, side)).filter(|p| !thinning.is_out(particle(grid, side, *p))).collect()
    };
    Some((0..cloth.grids().len()).map(|g| [0, 1, 2, 3].map(|side| kept(g, side))).collect())
}

impl<'a> Thinning<'a> {
    fn new(cloth: &'a Cloth) -> Self {
        let (grids, points) = (cloth.grids(), cloth.points());
        let mut places: BTreeMap<u32, Vec<_>> = BTreeMap::new();
        let mut on_border = vec![false; cloth.len()];
        for (g, grid) in grids.iter().enumerate() {
            for (side, place) in (0..4).flat_map(|s| (0..length(grid, s)).map(move |p| (s, p))) {
                let k = particle(grid, side, place);
                on_border[k] = true;
                places.entry(points[k]).or_default().push((g, side, place));
            }
        }
        // A point with a duplicate inside of a grid stays, so that the duplicates stay together.
        let mut stays = vec![false; cloth.len()];
        points.iter().zip(on_border).filter(|(_, on)| !on).for_each(|(point, _)| stays[*point as usize] = true);
        let mut thinning = Thinning { grids, left_out: vec![false; cloth.len()], points, places, stays };
        thinning.keep_ends(cloth);
        thinning
    }

    /// Keeps the ends of seams, and the points where several meet: openings keep their size, and no seam comes apart.
    fn keep_ends(&mut self, cloth: &Cloth) {
        let mut duplicates = vec![1; cloth.len()];
        for ring in 0..cloth.ring_count() {
            cloth.ring(ring).iter().for_each(|k| duplicates[*k as usize] = cloth.ring(ring).len());
        }
        for (&point, places) in &self.places {
            let mut beside = places.iter().flat_map(|&(g, side, place)| {
                let grid = &self.grids[g];
                let next = [place.checked_sub(1), Some(place + 1).filter(|p| *p < length(grid, side))];
                next.into_iter().flatten().map(move |p| particle(grid, side, p))
            });
            self.stays[point as usize] |= beside.any(|k| duplicates[k] < duplicates[point as usize]);
        }
    }

    fn is_out(&self, k: usize) -> bool {
        self.left_out[self.points[k] as usize]
    }

    /// Whether a point may be left out: it is not a corner nor the end of a seam, and its neighbours on all sides are kept.
    fn may_go(&self, point: u32) -> bool {
        let Some(places) = self.places.get(&point).filter(|_| !self.stays[point as usize]) else { return false };
        places.iter().all(|&(g, side, place)| {
            let grid = &self.grids[g];
            if place == 0 || place + 1 == length(grid, side) {
                return false;
            }
            let [a, b] = [place - 1, place + 1].map(|next| self.points[particle(grid, side, next)]);
            // A seam that folds keeps its fold, or two duplicates would be neighbours.
            let apart = a != b && a != point && b != point;
            apart && !self.left_out[a as usize] && !self.left_out[b as usize]
        })
    }

    /// Leaves out as many points as can go, those at odd places first: of a grid without seams every other one.
    fn thin(&mut self) {
        for odd in [true, false] {
            for (g, side) in (0..self.grids.len()).flat_map(|g| (0..4).map(move |side| (g, side))) {
                let grid = &self.grids[g];
                for place in (0..length(grid, side)).filter(|p| !odd || p % 2 == 1) {
                    let point = self.points[particle(grid, side, place)];
                    if !self.left_out[point as usize] && self.may_go(point) {
                        self.left_out[point as usize] = true;
                    }
                }
            }
        }
    }

    /// Puts points back until opposite sides keep the same number.
    fn balance(&mut self) -> Option<()> {
        let mut excess = Excess::new();
        let mut groups: BTreeMap<Vec<_>, Vec<u32>> = BTreeMap::new();
        for (point, places) in &self.places {
            let mut own = Excess::new();
            for &(g, side, _) in places {
                *own.entry((g, side / 2)).or_default() += if side % 2 == 0 { 1 } else { -1 };
            }
            own.retain(|_, n| *n != 0);
            if self.left_out[*point as usize] {
                groups.entry(own.into_iter().collect()).or_default().push(*point);
            } else {
                own.into_iter().for_each(|(pair, n)| *excess.entry(pair).or_default() += n);
            }
        }
        groups.remove(&Vec::new());
        let mut taken = 0u64;
        loop {
            let sum = |excess: &Excess| excess.values().map(|n| n.unsigned_abs()).sum::<u64>();
            let now = sum(&excess);
            if now == 0 {
                return Some(());
            }
            let moves = best(&excess, &groups).filter(|(_, then)| *then < now)?.0;
            for own in moves {
                let group = groups.get_mut(&own)?;
                // Spread along the border, so that cells keep their proportions.
                taken += 1;
                let at = (taken as f64 * 0.618_034).fract() * group.len() as f64;
                let point = group.remove(at as usize);
                if group.is_empty() {
                    groups.remove(&own);
                }
                self.left_out[point as usize] = false;
                own.iter().for_each(|(pair, n)| *excess.entry(*pair).or_default() += n);
            }
        }
    }
}

/// Change of the excess when a point is put back.
type Own = Vec<((usize, usize), i64)>;

/// The point, or the two points, that leave the least excess when they are put back, and how much that is.
fn best(excess: &Excess, groups: &BTreeMap<Own, Vec<u32>>) -> Option<(Vec<Own>, u64)> {
    let after = |moves: &[&Own]| {
        let mut then = excess.clone();
        moves.iter().copied().flatten().for_each(|(pair, n)| *then.entry(*pair).or_default() += n);
        then.values().map(|n| n.unsigned_abs()).sum::<u64>()
    };
    let now = after(&[]);
    let one = groups.keys().map(|a| (vec![a.clone()], after(&[a]))).min_by_key(|m| m.1)?;
    if one.1 < now {
        return Some(one);
    }
    let pairs = groups.iter().flat_map(|a| groups.iter().map(move |b| (a, b)));
    let enough = pairs.filter(|(a, b)| a.0 != b.0 || a.1.len() > 1);
    enough.map(|(a, b)| (vec![a.0.clone(), b.0.clone()], after(&[a.0, b.0]))).min_by_key(|m| m.1)
}
