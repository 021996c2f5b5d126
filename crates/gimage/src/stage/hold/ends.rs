//! Hems that hide where the body ends. Characters of games have no body beneath their clothes: where a cuff slides up an arm that is not there, a hand
//! hangs in the air. So a hem that lies around the body beside such an end goes less far than would uncover it.

use std::collections::HashMap;

use gimage_bundle::DisjointSets;

use super::rest::NEAR;
use super::sheet::Sheet;
use super::wearer::Wearer;
use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, distance, scale};

// Lengths, as shares of the height of body and garment together.

/// Largest distance of a hem from the end that it hides: 14 cm of a person.
const FAR: f64 = 0.08;
/// The least that a hem may go.
const LEAST: f64 = 0.0025;
/// How far from a hem limits end.
const REACH: f64 = 0.05;

/// Share of its way to the end that a hem may go.
const TOWARDS: f64 = 0.4;
/// Share of the points of a hem, and of an end, that lie near the other surface.
const TIGHT: f64 = 0.8;
/// Distance of the point of an end that is nearest to its middle, as a share of that of the farthest one, from which it goes around a limb: an open seam
/// does not.
const ROUND: f64 = 0.3;

/// The points \[m\] of a border of the body that goes around a limb.
pub(super) struct End(Vec<[f64; 3]>);

/// The ends of a body. Vertices at one place are one. O(n log n) in its triangles.
pub(super) fn of(body: &Mesh) -> Vec<End> {
    let mut number: HashMap<[u64; 3], u32> = HashMap::new();
    let mut places: Vec<[f64; 3]> = Vec::new();
    let mut welded = |v: u32| {
        let p = body.positions[v as usize];
        *number.entry(p.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
            places.push(p);
            places.len() as u32 - 1
        })
    };
    let mut sides: Vec<[u32; 2]> = Vec::with_capacity(3 * body.triangles.len());
    for t in &body.triangles {
        let [a, b, c] = t.map(&mut welded);
        sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]).iter().filter(|[a, b]| a != b));
    }
    sides.sort_unstable();
    let open: Vec<[u32; 2]> = sides.chunk_by(|a, b| a == b).filter(|run| run.len() == 1).map(|run| run[0]).collect();
    let mut loops = DisjointSets::new(places.len());
    for [a, b] in &open {
        loops.union(*a, *b);
    }
    let mut points: Vec<(u32, u32)> = open.iter().flatten().map(|&p| (loops.find(p), p)).collect();
    points.sort_unstable();
    points.dedup();
    let each = points.chunk_by(|a, b| a.0 == b.0);
    each.map(|run| End(run.iter().map(|(_, p)| places[*p as usize]).collect())).filter(End::is_round).collect()
}

impl End {
    fn is_round(&self) -> bool {
        let middle = middle(self.0.iter());
        let far = || self.0.iter().map(|p| distance(*p, middle));
        far().fold(f64::INFINITY, f64::min) >= ROUND * far().fold(0.0, f64::max)
    }
}

/// Shortens limits \[m\] around the hems of a garment that hide ends of the body, and returns the number of these hems. `pinned` and `limits` are by points,
/// `height` \[m\] is that of body and garment together. O(n log n) in the points of the garment.
pub(super) fn run(wearer: &Wearer, sheet: &Sheet, (pinned, limits): (&[bool], &mut [f64]), height: f64) -> usize {
    if wearer.ends.is_empty() {
        return 0;
    }
    let near = NEAR * height;
    let is_free = |hem: &&Vec<u32>| !hem.iter().any(|p| pinned[*p as usize]);
    let surface = std::cell::OnceCell::new();
    let mut count = 0;
    for hem in sheet.borders.iter().filter(is_free) {
        let at = |p: &u32| &sheet.positions[*p as usize];
        let center = middle(hem.iter().map(at));
        let beside = wearer.ends.iter().map(|end| (distance(middle(end.0.iter()), center), end));
        let beside: Vec<(f64, &End)> = beside.filter(|(far, _)| *far <= FAR * height).collect();
        if beside.is_empty() || !mostly(hem.iter().map(at), |p| wearer.near(p).0 <= near) {
            continue;
        }
        let surface = surface.get_or_init(|| Closest::new(&sheet.positions, &sheet.triangles));
        let lies_near = |p: [f64; 3]| surface.project(p).is_some_and(|found| found.distance <= near);
        let hidden = beside.into_iter().filter(|(_, end)| mostly(end.0.iter(), lies_near));
        let Some(way) = hidden.map(|(far, _)| far).reduce(f64::min) else { continue };
        let least = (TOWARDS * way).max(LEAST * height);
        let reach = REACH * height;
        let far = sheet.distances(hem.iter().copied(), reach);
        for ((limit, far), pinned) in limits.iter_mut().zip(far).zip(pinned) {
            // As limits beside pins: cloth that does not stretch goes no farther where they end.
            if far < reach && !pinned {
                *limit = limit.min(least + 2.0 * far * (far / reach).powi(2));
            }
        }
        count += 1;
    }
    count
}

fn middle<'a>(points: impl Iterator<Item = &'a [f64; 3]> + Clone) -> [f64; 3] {
    let count = points.clone().count().max(1) as f64;
    scale(points.fold([0.0; 3], |sum, p| add(sum, *p)), 1.0 / count)
}

/// Whether most points are so.
fn mostly<'a>(points: impl Iterator<Item = &'a [f64; 3]> + Clone, is_so: impl Fn([f64; 3]) -> bool) -> bool {
    let count = points.clone().count() as f64;
    points.filter(|p| is_so(**p)).count() as f64 >= TIGHT * count
}
