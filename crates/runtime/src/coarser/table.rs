//! The numbers by which a pass carries motion between the two images of a [`Coarser`], as shaders and their twins read them.

use super::Coarser;
use crate::cloth::{Cloth, other_end};
use crate::options::Solver;

/// Rounds of the fit; even, as two lists take turns.
pub(crate) const FITS: usize = 4;
/// Rounds over all springs, forward and backward by turns.
pub(crate) const ROUNDS: usize = 8;
/// Share of the shortest spring at a particle by which it moves at most.
const MOST: f64 = 0.25;

/// Words of 32 bits: a head, the stencils of fine particles, the rows of coarse ones, what their rows point to, and the springs of the
/// coarse image by colour. `shaders/part/table.wgsl` reads them.
#[derive(Debug, PartialEq)]
pub struct Table {
    words: Vec<u32>,
}

/// Words of the head.
const HEAD: usize = 8;
/// Words of a stencil: three coarse particles, and their weights.
const STENCIL: usize = 6;
/// Words of a coarse particle: its sample, where its entries begin and end, how far springs may move it \[m\], its share of the inverse
/// mass of its point, and its point.
const ROW: usize = 6;
/// Springs at one point that can have colours of their own; springs beyond them have a colour each.
const COLOURS: u32 = 128;

impl Coarser {
    /// The table of this image, `coarse` as the solver steps it, and the image that it was made of.
    pub(crate) fn table(&self, fine: &Cloth, coarse: &Cloth, solver: Solver) -> Table {
        self.table_where(|k| fine.particles()[k].exists(), coarse, solver)
    }

    /// The same of a fine image of which only the particles that exist are known.
    pub(crate) fn table_where(&self, exists: impl Fn(usize) -> bool, coarse: &Cloth, solver: Solver) -> Table {
        let (stencils, count) = (&self.map.stencils, coarse.len());
        let points: Vec<usize> = coarse.points().into_iter().map(|k| k as usize).collect();
        let mut near: Vec<Vec<[u32; 2]>> = vec![Vec::new(); count];
        let there = stencils.iter().enumerate().filter(|(k, _)| exists(*k));
        for (k, (c, w)) in there.flat_map(|(k, stencil)| stencil.parts().map(move |part| (k as u32, part))) {
            near[points[c]].push([k, w.to_bits()]);
        }
        let rows = HEAD + STENCIL * stencils.len();
        let entries = rows + ROW * count;
        let (mut places, mut next) = (Vec::with_capacity(count), entries);
        for list in &near {
            places.push([next, next + 2 * list.len()]);
            next += 2 * list.len();
        }
        let (most, colours) = springs(coarse, &points);
        let colours_at = next;
        let head = [stencils.len(), count, HEAD, rows, colours.len(), colours_at, 0, 0];
        let mut words: Vec<u32> = head.map(|n| n as u32).to_vec();
        words.extend(stencils.iter().flat_map(|s| s.of.into_iter().chain(s.weight.map(f32::to_bits))));
        let mut duplicates = vec![0u32; count];
        points.iter().for_each(|point| duplicates[*point] += 1);
        for (k, sample) in self.map.samples.iter().enumerate() {
            let [begins, ends] = places[points[k]].map(|at| at as u32);
            // As in `inverse_masses`, where the solver takes a duplicate for its share of the mass of the point.
            let share = if solver == Solver::Xpbd { 1.0 / duplicates[points[k]] as f32 } else { 1.0 };
            words.extend([*sample, begins, ends, most[k].to_bits(), share.to_bits(), points[k] as u32]);
        }
        words.extend(near.iter().flatten().flatten());
        let mut at = colours_at + colours.len() + 1;
        for colour in &colours {
            words.push(at as u32);
            at += 3 * colour.len();
        }
        words.push(at as u32);
        words.extend(colours.iter().flatten().flatten());
        Table { words }
    }
}

/// How far springs may move each point \[m\], and the springs by colour: their points and rest length. No two of a colour share a point.
fn springs(cloth: &Cloth, points: &[usize]) -> (Vec<f32>, Vec<Vec<[u32; 3]>>) {
    let mut most = vec![f32::MAX; cloth.len()];
    let mut taken = vec![0u128; cloth.len()];
    let mut colours: Vec<Vec<[u32; 3]>> = Vec::new();
    let mut beyond = Vec::new();
    for ([a, b], rest) in lengths(cloth, points) {
        [a, b].iter().for_each(|k| most[*k] = most[*k].min((MOST * rest) as f32));
        let spring = [a as u32, b as u32, (rest as f32).to_bits()];
        let colour = (taken[a] | taken[b]).trailing_ones();
        if colour == COLOURS {
            beyond.push(vec![spring]);
            continue;
        }
        [a, b].iter().for_each(|k| taken[*k] |= 1 << colour);
        colours.resize(colours.len().max(colour as usize + 1), Vec::new());
        colours[colour as usize].push(spring);
    }
    colours.extend(beyond);
    (most, colours)
}

/// The points that each spring joins, and its rest length \[m\].
pub(crate) fn lengths(cloth: &Cloth, points: &[usize]) -> impl Iterator<Item = ([usize; 2], f64)> {
    cloth.grids().iter().enumerate().flat_map(move |(g, grid)| {
        let (w, h) = (grid.width as usize, grid.height as usize);
        let all = (0..grid.texels()).flat_map(|k| (0..4).map(move |d| (k, d)));
        all.filter_map(move |(k, d)| {
            let (rest, other) = (f64::from(cloth.spring(g, k, d)), other_end(w, h, k, d)?);
            // Duplicates of one point may be neighbours.
            let ends = [k, other].map(|k| points[grid.first as usize + k]);
            (rest > 0.0 && ends[0] != ends[1]).then_some((ends, rest))
        })
    })
}

impl Table {
    /// All words, for a buffer.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    fn float(&self, at: usize) -> f32 {
        f32::from_bits(self.words[at])
    }

    /// The coarse particles that a fine one lies between, and their weights.
    pub fn stencil(&self, fine: usize) -> ([usize; 3], [f32; 3]) {
        let at = self.words[2] as usize + STENCIL * fine;
        ([0, 1, 2].map(|n| self.words[at + n] as usize), [3, 4, 5].map(|n| self.float(at + n)))
    }

    fn row(&self, coarse: usize) -> usize {
        self.words[3] as usize + ROW * coarse
    }

    /// The fine particle that a coarse one is.
    pub fn sample(&self, coarse: usize) -> usize {
        self.words[self.row(coarse)] as usize
    }

    /// The fine particles that lie beside a coarse one, and the weights that it has for them.
    pub fn near(&self, coarse: usize) -> impl Iterator<Item = (usize, f32)> {
        let [begins, ends] = [1, 2].map(|n| self.words[self.row(coarse) + n] as usize);
        (begins..ends).step_by(2).map(|e| (self.words[e] as usize, self.float(e + 1)))
    }

    /// How far springs may move a coarse particle \[m\].
    pub fn most(&self, coarse: usize) -> f32 {
        self.float(self.row(coarse) + 3)
    }

    /// The share of a coarse particle's inverse mass that its point has.
    pub fn share(&self, coarse: usize) -> f32 {
        self.float(self.row(coarse) + 4)
    }

    /// The first duplicate of a coarse particle.
    pub fn point(&self, coarse: usize) -> usize {
        self.words[self.row(coarse) + 5] as usize
    }

    /// Colours of springs.
    pub fn colours(&self) -> usize {
        self.words[4] as usize
    }

    /// The springs of a colour: their ends, and their rest length \[m\].
    pub fn springs(&self, colour: usize) -> impl Iterator<Item = ([usize; 2], f32)> {
        let at = self.words[5] as usize + colour;
        let [begins, ends] = [at, at + 1].map(|n| self.words[n] as usize);
        (begins..ends).step_by(3).map(|s| ([s, s + 1].map(|n| self.words[n] as usize), self.float(s + 2)))
    }
}
