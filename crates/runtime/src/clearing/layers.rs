//! Garments, and which of them are over which others.

use super::net::{Link, Net};
use crate::cloth::Cloth;
use crate::cloth::surface::{BodySurface, Posed};
use crate::number::real::{V3, cast};

/// Distance \[m\] within which two garments are compared.
const COMPARED_M: f64 = 0.03;
/// Points of a garment that are compared, at most, and points near the other one that decide, at least.
const SAMPLES: usize = 400;
const FEWEST: usize = 8;

/// Cloth that seams and stitches hold together.
pub struct Garment {
    /// The index of its cloth.
    pub cloth: usize,
    /// Its points and links in the net of the cloth.
    pub points: Vec<u32>,
    pub links: Vec<Link>,
    /// Its surface at the start, of all points of the net, if layers count for it.
    pub surface: Option<BodySurface>,
    /// Garments below it, by their places in the list; all of them are before it.
    pub below: Vec<usize>,
}

/// All garments, each after those below it. O(n), and O(log n) for each of [`SAMPLES`] points per pair of garments that lie near one another.
pub fn garments(cloths: &[Cloth], nets: &[Net]) -> Vec<Garment> {
    let mut list: Vec<Garment> = Vec::new();
    for (index, net) in nets.iter().enumerate() {
        let mut place = vec![usize::MAX; net.at.len()];
        for point in 0..net.at.len() {
            let first = net.garment[point] as usize;
            if place[first] == usize::MAX {
                place[first] = list.len();
                list.push(Garment {
                    cloth: index,
                    points: Vec::new(),
                    links: Vec::new(),
                    surface: None,
                    below: Vec::new(),
                });
            }
            list[place[first]].points.push(point as u32);
        }
        net.links.iter().for_each(|link| list[place[net.garment[link.ends[0] as usize] as usize]].links.push(*link));
    }
    if list.iter().filter(|garment| cloths[garment.cloth].contact.is_some()).count() > 1 {
        for garment in list.iter_mut().filter(|garment| cloths[garment.cloth].contact.is_some()) {
            garment.surface = surface(&cloths[garment.cloth], &nets[garment.cloth], garment);
        }
    }
    sorted(list, cloths, nets)
}

/// The drawn triangles of a garment; none without area.
fn surface(cloth: &Cloth, net: &Net, garment: &Garment) -> Option<BodySurface> {
    let own = net.garment[*garment.points.first()? as usize];
    let mut triangles = Vec::new();
    for corners in cloth.indices().as_chunks::<3>().0 {
        let [a, b, c] = corners.map(|k| net.of_particle[k as usize]);
        if a != b && b != c && c != a && net.garment[a as usize] == own {
            triangles.push([a, b, c]);
        }
    }
    BodySurface::new(net.at.iter().map(|p| cast(*p)).collect(), triangles, Vec::new()).ok()
}

/// Puts each garment after those below it, as far as garments are not over one another in a ring.
fn sorted(mut list: Vec<Garment>, cloths: &[Cloth], nets: &[Net]) -> Vec<Garment> {
    let count = list.len();
    let boxes: Vec<_> = list.iter().map(|garment| bounds(garment, nets)).collect();
    let posed: Vec<Option<Posed>> =
        list.iter().map(|g| Some(Posed::put(g.surface.as_ref()?, nets[g.cloth].at.clone()))).collect();
    // Whether the first garment is over the second one.
    let mut over = vec![vec![false; count]; count];
    for (a, b) in (0..count).flat_map(|b| (0..b).map(move |a| (a, b))) {
        let (Some(first), Some(second)) = (&posed[a], &posed[b]) else { continue };
        if (0..3).any(|c| boxes[a][0][c] > boxes[b][1][c] || boxes[b][0][c] > boxes[a][1][c]) {
            continue;
        }
        let layer = |g: usize| cloths[list[g].cloth].contact.map_or(0, |contact| contact.layer);
        let height = |g: usize, above: &Posed| {
            let points = &list[g].points;
            let each =
                points.iter().step_by(points.len().div_ceil(SAMPLES)).map(|k| nets[list[g].cloth].at[*k as usize]);
            let near = each.map(|p| above.near(p)).filter(|near| !near.is_beside && near.height.abs() < COMPARED_M);
            median(near.map(|near| near.height).collect())
        };
        let rise = match (layer(a) - layer(b), height(a, second), height(b, first)) {
            (_, None, None) => 0.0,
            (0, up, down) => up.unwrap_or(0.0) - down.unwrap_or(0.0),
            (layers, ..) => f64::from(layers),
        };
        (over[a][b], over[b][a]) = (rise > 0.0, rise < 0.0);
    }
    drop(posed);
    let mut order: Vec<usize> = Vec::new();
    while order.len() < count {
        let left = |g: &usize| (0..count).filter(|other| over[*g][*other] && !order.contains(other)).count();
        let Some(next) = (0..count).filter(|g| !order.contains(g)).min_by_key(left) else { break };
        list[next].below = (0..order.len()).filter(|place| over[next][order[*place]]).collect();
        order.push(next);
    }
    let mut slots: Vec<Option<Garment>> = list.into_iter().map(Some).collect();
    order.into_iter().filter_map(|g| slots[g].take()).collect()
}

/// The box around the points of a garment, larger by half of what is near \[m\].
fn bounds(garment: &Garment, nets: &[Net]) -> [V3<f64>; 2] {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for p in garment.points.iter().map(|k| nets[garment.cloth].at[*k as usize]) {
        for c in 0..3 {
            bounds[0][c] = bounds[0][c].min(p[c] - 0.5 * COMPARED_M);
            bounds[1][c] = bounds[1][c].max(p[c] + 0.5 * COMPARED_M);
        }
    }
    bounds
}

/// The middle one of enough numbers.
fn median(mut list: Vec<f64>) -> Option<f64> {
    list.sort_by(f64::total_cmp);
    if list.len() < FEWEST { None } else { list.get(list.len() / 2).copied() }
}
