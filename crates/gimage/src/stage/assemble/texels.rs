//! The texels of a piece that an expression of `--pin` or `--limit` selects.

use crate::base::mesh::{Channel, Mesh, NONE, Part, Semantic};
use crate::base::vec3::distance as distance_of;
use crate::stage::assemble::pins::Pin;
use crate::stage::image::PieceImage;

/// The texels of one piece, with all that expressions refer to.
#[derive(Clone, Copy)]
pub(super) struct Texels<'a> {
    /// The mesh with its attributes.
    pub mesh: &'a Mesh,
    /// The first piece of the family, which boundary loops name.
    pub piece: usize,
    /// The lowest and the highest point of the family \[m\].
    pub span: [f64; 2],
    /// The image.
    pub image: &'a PieceImage,
    /// The triangle of the mesh and the barycentric coordinates of each texel.
    pub places: &'a [(usize, [f64; 3])],
    /// The boundary loops of the garment as (piece, loop of the piece), longest first.
    pub loops: &'a [(usize, u32)],
    /// The same, highest first.
    pub heights: &'a [(usize, u32)],
}

impl<'a> Texels<'a> {
    /// The corners of a channel around texel `at` that have a value: barycentric coordinate and value.
    pub fn corners(&self, channel: &'a Channel, at: usize) -> impl Iterator<Item = (f64, &'a [f32])> {
        let (t, bary) = self.places[at];
        bary.into_iter().enumerate().filter_map(move |(c, b)| Some((b, channel.at(t, c)?)))
    }

    /// One component of a channel at texel `at`.
    pub fn value(&self, semantic: &Semantic, component: usize, at: usize) -> Option<f64> {
        let channel = self.mesh.channel(semantic).filter(|c| component < c.width)?;
        let (mut sum, mut total) = (0.0, 0.0);
        for (b, v) in self.corners(channel, at) {
            sum += b * f64::from(v[component]);
            total += b;
        }
        (total > 0.0).then(|| sum / total)
    }

    /// The part of the file that texel `at` lies on.
    fn part(&self, at: usize) -> Option<&Part> {
        self.mesh.parts.get(*self.mesh.triangle_part.get(self.places[at].0)? as usize)
    }

    /// Whether texel `at` meets an expression.
    fn meets(&self, expression: &Pin, at: usize) -> bool {
        let p = self.image.grid.positions[at];
        match expression {
            Pin::Above(y) => p[1] > *y,
            Pin::Below(y) => p[1] < *y,
            Pin::Top(share) => p[1] >= self.span[1] - share * (self.span[1] - self.span[0]),
            Pin::Box(lo, hi) => (0..3).all(|c| lo[c] <= p[c] && p[c] <= hi[c]),
            Pin::Loop(l) => self.loops.get(*l) == Some(&(self.piece, self.image.loop_of[at])),
            Pin::LoopAny => self.image.loop_of[at] != NONE,
            Pin::Material(name) => self.part(at).is_some_and(|part| name.matches(&part.material)),
            Pin::Node(name) => self.part(at).is_some_and(|part| name.matches(&part.node)),
            Pin::LoopTop => self.heights.first() == Some(&(self.piece, self.image.loop_of[at])),
            Pin::LoopBottom => self.heights.last() == Some(&(self.piece, self.image.loop_of[at])),
            Pin::Joint(name, distance) => {
                let joints = self.mesh.skeleton.joints.iter().filter(|j| j.name == *name);
                let mut far = joints.map(|j| distance_of(p, [j.world[12], j.world[13], j.world[14]]));
                far.any(|d| d <= *distance)
            }
            Pin::Not(a) => !self.meets(a, at),
            Pin::And(a, b) => self.meets(a, at) && self.meets(b, at),
            Pin::Or(a, b) => self.meets(a, at) || self.meets(b, at),
            Pin::Attribute(name, t) => self.value(&Semantic::Custom(name.clone()), 0, at).is_some_and(|x| x > *t),
            Pin::Color(c, t) => self.value(&Semantic::Color(0), *c, at).is_some_and(|x| x > *t),
        }
    }

    /// Calls `each` with the expression and the texel wherever one of these is met; returns which are met at all.
    pub fn select<'p>(
        &self,
        expressions: impl ExactSizeIterator<Item = &'p Pin>,
        mut each: impl FnMut(usize, usize),
    ) -> Vec<bool> {
        let mut met = vec![false; expressions.len()];
        for (e, expression) in expressions.enumerate() {
            for at in (0..self.places.len()).filter(|&at| self.meets(expression, at)) {
                met[e] = true;
                each(e, at);
            }
        }
        met
    }
}

/// Which texels are pinned, all duplicates of a point if one of them is, and which pins a texel meets.
pub(super) fn pinned(texels: &Texels<'_>, pins: &[Pin]) -> (Vec<bool>, Vec<bool>) {
    let mut out = vec![false; texels.places.len()];
    let met = texels.select(pins.iter(), |_, at| out[at] = true);
    for ring in texels.image.grid.rings() {
        if ring.iter().any(|&k| out[k as usize]) {
            ring.iter().for_each(|&k| out[k as usize] = true);
        }
    }
    (out, met)
}
