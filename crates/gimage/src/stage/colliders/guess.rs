//! Parts of the body that a file leaves out beneath clothes, guessed from the clothes: characters of games often have a head, arms and hands, and nothing under the shirt.
//!
//! Guesses a body beneath the innermost garment for each bone that a garment surrounds and no body does.

use gimage_bundle::Winding;
use rayon::prelude::*;

use super::fit::{self, Limits, Placed};
use super::samples::{INSIDE, Sample, join_small, normal, strongest};
use super::solid::Solid;
use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::scatter::Sampler;
use crate::base::vec3::{add, distance, dot, normalize, scale, sub};
use crate::stage::import::bones;

/// Solids of what is missing, at most.
const COUNT: usize = 16;
/// How much farther than those of a body they may be from it.
const LOOSE: f64 = 2.0;
/// Samples of the garments.
const SAMPLES: usize = 2_000;
/// Shares of the height of body and clothes: cloth nearer to the body than the first lies on it, cloth farther from its bone than the second hangs free.
const NEAR: f64 = 0.025;
const FAR: f64 = 0.12;
/// Cosine of the angle between the normal of cloth around a bone and the way from the bone, at least.
const AROUND: f64 = 0.5;
/// Samples of a part that is guessed, at least: fewer are gaps between body and cloth.
const FEWEST: usize = 25;
/// Width of a solid as a share of that which fits the clothes. Clothes of such characters are as wide as the body that they hide: where an
/// animation lowers an arm, solids as wide would cross, and contact would push the sleeve from one into the other.
const ROOM: f64 = 0.7;
/// Depth of a point that is inside, as a share of the way to the bone.
const DEEP: f64 = 0.5;

/// Solids in place of what is missing, which lie `below` \[m\] beneath the garments, and their samples.
pub(super) fn guess(body: (&Mesh, &Winding), cloth: &Mesh, limits: &Limits, below: f64) -> (Vec<Placed>, Vec<Sample>) {
    let mut samples = samples(body, cloth, below);
    let parents: Vec<Option<u32>> = cloth.skeleton.joints.iter().map(|j| j.parent).collect();
    join_small(&mut samples, &parents);
    let of = |samples: &[Sample], joint: Option<u32>| {
        samples.iter().filter(|s| s.joint == joint && s.is_on_surface()).count()
    };
    let counted = samples.clone();
    samples.retain(|s| s.is_outside() || of(&counted, s.joint) >= FEWEST);
    if !samples.iter().any(Sample::is_on_surface) {
        return (Vec::new(), Vec::new());
    }
    let limits = Limits { target: LOOSE * limits.target, count: COUNT, ..*limits };
    let placed = fit::fit(&samples, &limits);
    samples.retain(Sample::is_on_surface);
    (placed, samples)
}

/// Solids with room between them and the clothes.
pub(super) fn narrowed(placed: &[Placed]) -> Vec<Placed> {
    let one = |p: &Placed| Placed { solid: Solid { form: p.solid.form.narrowed(ROOM), ..p.solid }, ..*p };
    placed.iter().map(one).collect()
}

/// Points beneath the innermost garments, points inside of what is missing, and points of the garments, which are outside.
fn samples((body, winding): (&Mesh, &Winding), cloth: &Mesh, below: f64) -> Vec<Sample> {
    let bones = bones(&cloth.skeleton);
    let corners: Vec<_> = (0..cloth.triangles.len()).map(|t| cloth.corners(t)).collect();
    let sampler = Sampler::new(&corners, SAMPLES, 4);
    let (Some((low, high)), Some((foot, top))) = (body.bounds(), cloth.bounds()) else { return Vec::new() };
    if sampler.area() <= 0.0 {
        return Vec::new();
    }
    let height = high[1].max(top[1]) - low[1].min(foot[1]);
    let [skin, clothes] = [body, cloth].map(|mesh| Closest::new(&mesh.positions, &mesh.triangles));
    // The nearest point of any bone of the clothes that no body is around.
    let followed = cloth.followed(|_| true);
    let bare: Vec<[[f64; 3]; 2]> = bones
        .iter()
        .filter(|bone| followed.contains(&bone.joint) || followed.contains(&bone.parent))
        .map(|bone| bone.ends)
        .collect();
    let at_bone = |p: [f64; 3]| {
        let each = bare.iter().map(|ends| on_line(p, *ends));
        each.min_by(|a, b| distance(p, *a).total_cmp(&distance(p, *b))).filter(|q| winding.number(*q) < INSIDE)
    };
    let of = |i: usize| {
        let (point, t) = sampler.at(i);
        let n = normal(corners[t]);
        let mut out = vec![Sample { point, joint: None, low: 0.0, high: f64::INFINITY }];
        let Some(bone) = at_bone(point) else { return out };
        let (far, way) = (distance(point, bone), normalize(sub(point, bone)));
        let is_near_body = skin.project(point).is_none_or(|near| near.distance < NEAR * height);
        if is_near_body || far > FAR * height || far < 2.0 * below || dot(n, way) < AROUND {
            return out;
        }
        let inward = scale(n, -1.0);
        let start = add(point, scale(inward, 0.1 * below));
        // Another garment that faces the same way is further in.
        if clothes.along(start, inward, far, |other, m| other != t as u32 && dot(m, n) > AROUND).is_some() {
            return out;
        }
        let joint = strongest(cloth, t, point);
        let skin = add(point, scale(inward, below));
        out.push(Sample::on(skin, joint));
        let inside = add(bone, scale(sub(skin, bone), DEEP));
        out.push(Sample { point: inside, joint, low: f64::NEG_INFINITY, high: 0.0 });
        out
    };
    (0..SAMPLES).into_par_iter().flat_map_iter(of).collect()
}

/// The point of a line that is nearest to `p`.
fn on_line(p: [f64; 3], [a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    let along = sub(b, a);
    let t = (dot(sub(p, a), along) / dot(along, along).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    add(a, scale(along, t))
}
