//! Contact of cloth with cloth: its settings, and which particles are too near on the surface to count.

use super::Cloth;
use crate::error::{Result, check as range};

/// The promise of contact of cloth with cloth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ContactTier {
    /// Pushes between particles, and no promise: fast or strongly folded cloth can still pass through itself. `gimage check-crossings`
    /// counts.
    #[default]
    Particles,
    /// The same pushes, and each step ends with positions in which no drawn triangle crosses another one of cloth of this tier, if the start has
    /// no crossing; triangles that cross at the start are guarded as soon as they are apart. Pins and joints
    /// that leave cloth no room are not held back: [`crate::Fate::Crossed`] reports crossings that follow, on the GPU once the host examines the
    /// cloth ([`crate::Stepper::examine`]).
    Safe,
}

/// Contact of a cloth with itself and with other cloths that have contact: particles nearer than a distance are pushed apart.
///
/// The tier decides which promise it makes. Cloth without contact has no pass and no buffer for it. Cloth that crosses at the start is taken apart
/// within about a second on the CPU backend, and before the first frame on the GPU backend ([`crate::Scene::take_apart`]): the smaller part on one side of a crossing moves to the other side, or the part that [`ClothContact::layer`]
/// calls wrong. Cloth that does not cross pays one search for crossings in the first frame. [`crate::Fate::Tangled`] reports crossings that are left after 2 s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClothContact {
    /// The promise of contact. Default [`ContactTier::Particles`].
    pub tier: ContactTier,
    /// Distance \[m\] that particles keep. Default none: 1.2 times the mean distance of neighbouring particles, below which triangles of
    /// nearly square cells, a little stretched, cannot pass between particles, or twice the thickness of the cloth if that is larger. Above 0, at most 1. Particles
    /// that are nearer at rest keep their distance at rest.
    pub distance: Option<f32>,
    /// Coefficient of friction. Default 0.3; 0 to 1e6; larger slides less.
    pub friction: f32,
    /// Which side of other cloths it belongs on: cloth of a higher layer comes out in front of cloth of a lower one, on the side that the normals of the
    /// lower one point to. Used where cloths cross; between cloths of one layer the smaller part moves. Default 0; any number.
    pub layer: i32,
}

impl Default for ClothContact {
    fn default() -> Self {
        ClothContact { tier: ContactTier::Particles, distance: None, friction: 0.3, layer: 0 }
    }
}

impl ClothContact {
    /// Refuses numbers outside their ranges.
    pub(crate) fn check(&self) -> Result<()> {
        let distance = f64::from(self.distance.unwrap_or(1.0));
        range("the contact distance of a cloth [m]", distance, "above 0, at most 1", |d| d > 0.0 && d <= 1.0)?;
        range("the contact friction of a cloth", f64::from(self.friction), "0 to 1e6", |f| (0.0..=1e6).contains(&f))
    }
}

/// The chosen contact distance over the mean distance of neighbours: as large as triangles need that are stretched by a fifth.
const SPACING_SHARE: f32 = 1.2;

/// Cells on the surface within which particles do not touch.
pub(crate) const SKIPPED_CELLS: usize = 1;

/// Which particles are left out of contact as they are near on the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Kin {
    /// For every particle the first of its duplicates: the one that others meet.
    pub first: Vec<u32>,
    /// Offsets into `members`, one more than particles; empty without seams.
    pub starts: Vec<u32>,
    /// For every particle, in ascending order, first duplicates within [`SKIPPED_CELLS`] cells on the surface, where a seam lies between
    /// or beside: particles of its grid within as many columns and rows are not listed.
    pub members: Vec<u32>,
}

impl Kin {
    /// That of a cloth. Takes time linear in its particles.
    pub fn of(cloth: &Cloth) -> Self {
        let first = cloth.points();
        if cloth.ring_count() == 0 {
            return Kin { first, ..Kin::default() };
        }
        let mut walk = Walk::new(cloth);
        let near = walk.beside_seams();
        let (mut starts, mut members) = (vec![0], Vec::new());
        for (k, near) in near.into_iter().enumerate() {
            if near {
                let found = walk.around(k);
                let mut listed: Vec<u32> =
                    found.iter().map(|m| first[*m]).filter(|m| !walk.is_close(k, *m as usize)).collect();
                listed.sort_unstable();
                listed.dedup();
                members.extend(listed);
            }
            starts.push(members.len() as u32);
        }
        Kin { first, starts, members }
    }

    /// The members of a particle.
    pub fn of_particle(&self, k: usize) -> &[u32] {
        match self.starts.get(k..k + 2) {
            Some(ends) => &self.members[ends[0] as usize..ends[1] as usize],
            None => &[],
        }
    }
}

/// Goes from particle to particle, across seams too.
struct Walk<'a> {
    cloth: &'a Cloth,
    /// The ring of each particle, `u32::MAX` for none.
    rings: Vec<u32>,
    /// The last walk, by its first particle, that came to each particle.
    seen: Vec<u32>,
}

impl<'a> Walk<'a> {
    fn new(cloth: &'a Cloth) -> Self {
        let mut rings = vec![u32::MAX; cloth.len()];
        for ring in 0..cloth.ring_count() {
            cloth.ring(ring).iter().for_each(|k| rings[*k as usize] = ring as u32);
        }
        Walk { cloth, rings, seen: vec![u32::MAX; cloth.len()] }
    }

    /// The grid of a particle, its column and its row.
    fn place(&self, k: usize) -> (usize, [usize; 2]) {
        let grids = self.cloth.grids();
        let g = grids.partition_point(|g| g.first as usize <= k) - 1;
        let (at, width) = (k - grids[g].first as usize, grids[g].width as usize);
        (g, [at % width, at / width])
    }

    /// Whether two particles are of one grid and within as many columns and rows.
    fn is_close(&self, k: usize, m: usize) -> bool {
        let ((g, a), (h, b)) = (self.place(k), self.place(m));
        g == h && a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])) <= SKIPPED_CELLS
    }

    /// Calls `each` with the particles of the grid within `cells` columns and rows.
    fn square(&self, k: usize, cells: usize, mut each: impl FnMut(usize)) {
        let (g, [i, j]) = self.place(k);
        let grid = &self.cloth.grids()[g];
        let (width, height) = (grid.width as usize, grid.height as usize);
        for row in j.saturating_sub(cells)..(j + cells + 1).min(height) {
            for column in i.saturating_sub(cells)..(i + cells + 1).min(width) {
                let m = grid.first as usize + row * width + column;
                if self.cloth.particles()[m].exists() {
                    each(m);
                }
            }
        }
    }

    /// For each particle whether a seam is near.
    fn beside_seams(&self) -> Vec<bool> {
        let mut near = vec![false; self.cloth.len()];
        for k in (0..self.cloth.len()).filter(|k| self.rings[*k] != u32::MAX) {
            self.square(k, SKIPPED_CELLS, |m| near[m] = true);
        }
        near
    }

    /// All particles within reach of one on the surface, itself and its duplicates too.
    fn around(&mut self, k: usize) -> Vec<usize> {
        let mut found = vec![];
        let mut next = vec![k];
        for step in 0..=SKIPPED_CELLS {
            let mut circle = Vec::new();
            for m in next {
                let ring = self.rings[m];
                let mates: &[u32] = if ring == u32::MAX { &[] } else { self.cloth.ring(ring as usize) };
                for m in mates.iter().map(|m| *m as usize).chain([m]) {
                    if self.seen[m] != k as u32 {
                        self.seen[m] = k as u32;
                        circle.push(m);
                    }
                }
            }
            found.extend(&circle);
            next = Vec::new();
            if step < SKIPPED_CELLS {
                circle.iter().for_each(|m| self.square(*m, 1, |n| next.push(n)));
            }
        }
        found
    }
}

impl Cloth {
    /// The distance \[m\] that its particles keep from particles beyond their neighbours; `thickness` \[m\] is that of cloth without
    /// one of its own. 0 without contact.
    pub(crate) fn contact_distance(&self, thickness: f32) -> f32 {
        let Some(contact) = &self.contact else { return 0.0 };
        let chosen = || {
            (2.0 * self.thickness.unwrap_or(thickness))
                .max(SPACING_SHARE * self.spacing())
                .clamp(f32::MIN_POSITIVE, 1.0)
        };
        contact.distance.unwrap_or_else(chosen)
    }

    /// The mean distance \[m\] of particles from those to the right and below, at the start; 0 if there are none.
    pub(crate) fn spacing(&self) -> f32 {
        let (mut sum, mut count) = (0.0, 0u32);
        for (g, grid) in self.grids().iter().enumerate() {
            for k in 0..grid.texels() {
                for d in 0..2 {
                    let Some(other) = self.neighbour(g, k, d) else { continue };
                    let k = grid.first as usize + k;
                    if self.particles()[k].exists() && self.particles()[other].exists() {
                        let (a, b) = (self.positions()[k], self.positions()[other]);
                        sum += [0, 1, 2].map(|c| f64::from(a[c] - b[c]).powi(2)).iter().sum::<f64>().sqrt();
                        count += 1;
                    }
                }
            }
        }
        if count > 0 { (sum / f64::from(count)) as f32 } else { 0.0 }
    }
}
