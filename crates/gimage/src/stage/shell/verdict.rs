//! Decides whether a group of triangles is a shell, and which of its sheets stays.

use std::collections::{BTreeMap, BTreeSet};

use gimage_bundle::DisjointSets;

use super::alone::alone;
use super::doubled::doubled;
use super::layers::Layer;
use super::rays::{FACING, quantile};
use super::sides::Sides;
use super::zone::Zone;
use crate::base::vec3::{add, distance, dot, norm, scale, sub};
use crate::base::words::number;
use crate::stage::component::Component;

/// Smallest share of a component's area that faces another sheet. Below [`FACING`] the rest has to be rims and padding in small places, as on a hood: the inner
/// sheet of wide padding would stay as a loose layer.
const LEAST_FACING: f64 = 0.6;
/// Smallest share of the faced area whose partners lie on the other sheet.
const AGREE: f64 = 0.95;
/// Smallest area of a sheet over that of the other one.
const UNEVEN: f64 = 0.5;
/// Smallest share of the area that lies on one of the sheets and not on the rim.
const ON_SHEETS: f64 = 0.5;
/// Thickness over the side of a square with the area of a sheet, below which two sheets without a rim are one shell: they could
/// be the front and the back of a garment laid flat.
const TWO_SHEETS: f64 = 0.01;
/// Thickness over the width of a sheet above which it is a cord.
const NARROW: f64 = 0.25;
/// Share of the sheet's border that may run along both sheets in one loop, as the openings of a garment laid flat do.
const MIXED: f64 = 0.1;
/// Length of the mean normal of a sheet from which it may be one side of a garment laid flat: the outer sheet of one that is worn faces all ways.
const ONE_WAY: f64 = 0.5;
/// Smallest share of the triangles that a sheet has: a sheet and a ring of triangles along its border have about as many. Below it, a few
/// spikes of a damaged file hold most of the area.
const FEW: f64 = 0.05;
/// Mean cosine between normals of sheets and ways from a point from which they lie around that point.
const AROUND: f64 = 0.12;
/// Areas closer than this share do not tell the outer sheet.
const EVEN: f64 = 0.02;

/// The outcome for a group.
pub(super) enum Verdict {
    /// It does not look like a shell.
    Plain,
    /// It looks like one, but is kept; with the reason.
    Doubtful(Doubt),
    /// One of its sheets stays.
    Shell(Found),
}

/// A group that looks like a shell, but is kept.
pub(super) struct Doubt {
    pub components: Vec<u32>,
    pub reason: String,
}

/// A shell.
pub(super) struct Found {
    /// Its components.
    pub components: Vec<u32>,
    /// The triangles of the zone that stay, ascending.
    pub kept: Vec<u32>,
    /// The triangles of the sheet that faces them.
    pub facing: Vec<u32>,
    /// All that go: the facing sheet and the rim.
    pub dropped: Vec<u32>,
    /// Fabric of one layer, which stays as it is.
    pub alone: Vec<u32>,
    /// Median distance of the sheets \[m\], with the distances that 5 % and 95 % of the area lie below.
    pub thickness: [f64; 3],
    /// Share of its area that has an opposite sheet.
    pub share: f64,
}

/// The inputs of a verdict.
pub(super) struct Evidence<'a> {
    pub zone: &'a Zone,
    pub sides: &'a Sides,
    pub layers: &'a [Layer],
    pub positions: &'a [[f64; 3]],
    pub components: &'a [Component],
    /// The centre of the garment \[m\].
    pub centre: [f64; 3],
}

impl Evidence<'_> {
    /// The verdict on each group, in the order of their first triangles. O(n log n).
    pub fn verdicts(&self) -> Vec<Verdict> {
        let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        self.sides.group.iter().enumerate().for_each(|(t, &g)| groups.entry(g).or_default().push(t as u32));
        groups.values().map(|triangles| self.verdict(triangles)).collect()
    }

    fn verdict(&self, triangles: &[u32]) -> Verdict {
        let members: BTreeSet<u32> = triangles.iter().map(|&t| self.zone.component[t as usize]).collect();
        let components: Vec<u32> = members.into_iter().collect();
        let faced = |t: &u32| self.zone.gap[*t as usize].is_finite();
        let share_of = |c: u32| {
            let own: Vec<u32> = triangles.iter().copied().filter(|&t| self.zone.component[t as usize] == c).collect();
            let all = self.area(own.iter());
            if all > 0.0 { self.area(own.iter().filter(|t| faced(t))) / all } else { 0.0 }
        };
        let shares: Vec<f64> = components.iter().map(|&c| share_of(c)).collect();
        let least = shares.iter().copied().fold(1.0, f64::min);
        let doubt = |reason: String| Verdict::Doubtful(Doubt { components: components.clone(), reason });
        let partly = |enough: f64| {
            if shares.iter().all(|&s| s < enough) {
                return Verdict::Plain;
            }
            let thin = shares.iter().position(|&s| s == least).map_or("", |k| self.name(components[k]));
            doubt(format!("the second sheet covers only {:.0} % of {thin}", 100.0 * least))
        };
        if least < LEAST_FACING {
            return partly(LEAST_FACING);
        }
        let mut found = self.found(triangles, components.clone());
        if found.thickness[0] > NARROW * self.width(&found.kept) {
            return Verdict::Plain;
        }
        let fewest = found.kept.len().min(found.facing.len());
        if (fewest as f64) < FEW * triangles.len() as f64 {
            if 2 * triangles.iter().filter(|t| faced(t)).count() < triangles.len() {
                return Verdict::Plain;
            }
            return doubt("its two sheets hang together, so that one cannot be told from the other".into());
        }
        found.share = self.area(triangles.iter().filter(|t| faced(t))) / self.area(triangles.iter());
        if let Some(reason) = self.objection(&found, triangles) {
            return doubt(reason);
        }
        let [_, _, thickest] = found.thickness;
        found.alone = alone(self.zone, self.sides, self.positions, &found.kept, &found.dropped, thickest);
        if least < FACING && !found.alone.is_empty() {
            return partly(FACING);
        }
        let stay = found.kept.iter().chain(&found.alone).copied().collect();
        let Some(over) = doubled(self.zone, self.sides, self.positions, &stay, thickest) else {
            return doubt("without its rims its outer sheet would fall apart".into());
        };
        for list in [&mut found.kept, &mut found.alone] {
            list.retain(|t| over.binary_search(t).is_err());
        }
        found.dropped.retain(|t| found.alone.binary_search(t).is_err());
        found.dropped.extend(over);
        found.dropped.sort_unstable();
        found.dropped.dedup();
        Verdict::Shell(found)
    }

    fn found(&self, triangles: &[u32], components: Vec<u32>) -> Found {
        let on = |layer: Layer| {
            let list = triangles.iter().copied().filter(move |&t| self.layers[t as usize] == layer);
            list.collect::<Vec<u32>>()
        };
        let (first, second) = (on(Layer::First), on(Layer::Second));
        let layer = if self.is_outer(&first, &second) { Layer::First } else { Layer::Second };
        let (kept, facing) = if layer == Layer::First { (first, second) } else { (second, first) };
        let mut gaps: Vec<(f64, f64)> = kept
            .iter()
            .map(|&t| (self.zone.gap[t as usize], self.zone.area[t as usize]))
            .filter(|x| x.0.is_finite())
            .collect();
        gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
        Found {
            components,
            dropped: triangles.iter().copied().filter(|&t| self.layers[t as usize] != layer).collect(),
            alone: Vec::new(),
            kept,
            facing,
            thickness: [0.5, 0.05, 0.95].map(|q| quantile(&gaps, q).unwrap_or(0.0)),
            share: 0.0,
        }
    }

    /// Whether the first of two sheets is the outer one: the one that faces away from the middle of both, as sleeves do wherever they are, else the one that
    /// faces away from the garment's centre, as collars and pockets do. Of sheets that lie around neither the larger one: a lining with hems may be larger
    /// than what it lines, so size comes after these.
    fn is_outer(&self, first: &[u32], second: &[u32]) -> bool {
        let [a, b] = [first, second].map(|list| self.area(list.iter()));
        let middle = |t: u32| {
            let [p, q, r] = self.zone.triangles[t as usize].map(|v| self.positions[v as usize]);
            scale(add(p, add(q, r)), 1.0 / 3.0)
        };
        let both = || first.iter().chain(second).copied();
        let sum = both().map(|t| scale(middle(t), self.zone.area[t as usize])).fold([0.0; 3], add);
        let own = scale(sum, 1.0 / (a + b).max(f64::MIN_POSITIVE));
        // How much more the first one faces away from a point, as a mean cosine.
        let away = |centre: [f64; 3]| {
            let of = |t: u32| self.zone.area[t as usize] * dot(self.zone.normal[t as usize], sub(middle(t), centre));
            let [x, y] = [first, second].map(|list| list.iter().map(|t| of(*t)).sum::<f64>());
            let far: f64 = both().map(|t| self.zone.area[t as usize] * distance(middle(t), centre)).sum();
            if (x - y).abs() > 1e-9 * (x.abs() + y.abs()) { (x - y) / far } else { 0.0 }
        };
        let ways = [own, self.centre].map(away);
        if let Some(way) = ways.into_iter().find(|way| way.abs() > AROUND) {
            return way > 0.0;
        }
        if (a - b).abs() > EVEN * a.max(b) {
            return a > b;
        }
        if ways[1] != 0.0 {
            return ways[1] > 0.0;
        }
        // A plate through the centre: any rule that does not depend on the order of the file.
        let whole = |list: &[u32]| {
            let of = |&t: &u32| scale(self.zone.normal[t as usize], self.zone.area[t as usize]);
            list.iter().map(of).fold([0.0; 3], add)
        };
        let difference = sub(whole(first), whole(second));
        difference.iter().find(|x| x.abs() > 0.1 * norm(difference)).is_none_or(|&x| x > 0.0)
    }

    /// The reason why a shell is not to be trusted.
    fn objection(&self, found: &Found, triangles: &[u32]) -> Option<String> {
        let [kept, facing] = [&found.kept, &found.facing].map(|list| self.area(list.iter()));
        if kept + facing < ON_SHEETS * self.area(triangles.iter()) || kept.min(facing) < UNEVEN * kept.max(facing) {
            return Some("its sheets cannot be told apart, or one is much larger".into());
        }
        let (mut agree, mut all) = (0.0, 0.0);
        let own: BTreeSet<u32> = triangles.iter().copied().collect();
        for pair in self.zone.pairs.iter().filter(|p| own.contains(&p.triangle)) {
            let (a, b) = (self.layers[pair.triangle as usize], self.layers[pair.other as usize]);
            if a != Layer::Rim && b != Layer::Rim {
                all += self.zone.area[pair.triangle as usize];
                agree += if a == b.facing() { self.zone.area[pair.triangle as usize] } else { 0.0 };
            }
        }
        if agree < AGREE * all {
            return Some(format!("only {:.0} % of the facing area lies on two different sheets", 100.0 * agree / all));
        }
        let thickness = found.thickness[0];
        let sheets = |list: &[u32]| list.iter().map(|&t| self.zone.component[t as usize]).collect::<BTreeSet<_>>();
        let apart = sheets(&found.kept).is_disjoint(&sheets(&found.facing));
        if apart && thickness > TWO_SHEETS * kept.sqrt() {
            return Some(format!(
                "two separate sheets {} m apart could be two sides of a garment laid flat",
                number(thickness)
            ));
        }
        let border = self.border(&found.kept);
        (self.mixed(&own, 5.0 * thickness) > MIXED * border && self.one_way(&found.kept) > ONE_WAY)
            .then(|| "its openings run along both sheets, as those of a garment laid flat".into())
    }

    /// Length of the border of a sheet \[m\].
    fn border(&self, kept: &[u32]) -> f64 {
        let own: BTreeSet<u32> = kept.iter().copied().collect();
        let length = |[a, b]: [u32; 2]| distance(self.positions[a as usize], self.positions[b as usize]);
        let inner = self.sides.edges.iter().filter(|e| own.contains(&e.triangles[0]) != own.contains(&e.triangles[1]));
        let outer = self.sides.border.iter().filter(|e| own.contains(&e.triangle));
        inner.map(|e| length(e.vertices)).sum::<f64>() + outer.map(|e| length(e.vertices)).sum::<f64>()
    }

    /// Width of a sheet \[m\], as that of a long strip of its area and border; infinite without a border.
    fn width(&self, kept: &[u32]) -> f64 {
        2.0 * self.area(kept.iter()) / self.border(kept)
    }

    /// Length of the mean normal of a sheet.
    fn one_way(&self, kept: &[u32]) -> f64 {
        let of = |&t: &u32| scale(self.zone.normal[t as usize], self.zone.area[t as usize]);
        norm(kept.iter().map(of).fold([0.0; 3], add)) / self.area(kept.iter())
    }

    /// Length of the boundary loops that run along both sheets for more than `most` each \[m\].
    fn mixed(&self, own: &BTreeSet<u32>, most: f64) -> f64 {
        let rims: Vec<_> = self.sides.border.iter().filter(|e| own.contains(&e.triangle)).collect();
        let mut loops = DisjointSets::new(self.positions.len());
        rims.iter().for_each(|e| _ = loops.union(e.vertices[0], e.vertices[1]));
        let mut lengths: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
        for e in rims {
            let [a, b] = e.vertices.map(|v| self.positions[v as usize]);
            let at = lengths.entry(loops.find(e.vertices[0])).or_default();
            match self.layers[e.triangle as usize] {
                Layer::First => at[0] += distance(a, b),
                Layer::Second => at[1] += distance(a, b),
                Layer::Rim => {}
            }
        }
        lengths.values().filter(|[a, b]| a.min(*b) > most).map(|[a, b]| a + b).sum()
    }

    fn area<'b>(&self, triangles: impl Iterator<Item = &'b u32>) -> f64 {
        triangles.map(|&t| self.zone.area[t as usize]).sum()
    }

    fn name(&self, component: u32) -> &str {
        &self.components[component as usize].name
    }
}
