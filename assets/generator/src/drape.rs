//! Hangs a garment on the figure: particles and springs under gravity until they rest.

use crate::body::Body;
use crate::layers::Layers;
use crate::math::{V3, add, cross, dot, norm, scale, smoothstep, sub, unit};
use crate::sew::{Garment, Spring};

/// How to drape.
pub struct Drape<'a> {
    /// The body that the cloth must stay outside of.
    pub body: &'a Body,
    /// Particles held where they are.
    pub pins: &'a [usize],
    /// Time steps.
    pub steps: usize,
    /// How strongly folds are resisted, 0 to 1.
    pub bend: f64,
    /// How much of the sideways motion at contact is lost, 0 to 1.
    pub friction: f64,
    /// The distance kept from the body.
    pub gap: f64,
    /// How far apart two layers of cloth are kept.
    pub layer: f64,
    /// A last say about where a particle may be.
    pub limit: &'a dyn Fn(usize, V3) -> V3,
}

/// The greatest step, well under the distance between layers, so that they do not pass through each other.
const SPEED: f64 = 0.012;

/// Runs the drape.
pub fn drape(g: &mut Garment, how: &Drape) {
    let (stretch, bends) = g.springs();
    let mut weight = vec![1.0; g.x.len()];
    how.pins.iter().for_each(|&i| weight[i] = 0.0);
    let mut before = g.x.clone();
    let layers = Layers::new(&stretch, g.x.len());
    let dt2 = 1.0 / 3600.0;
    for step in 0..how.steps {
        // Less weight towards the end: the springs then take back the stretch that heavy cloth leaves in them.
        // Stiffness against folding, which also works against the lengths, goes last.
        let done = step as f64 / how.steps as f64;
        let gravity = -9.81 * dt2 * (1.0 - 0.9 * smoothstep(0.5, 0.85, done));
        let bend = how.bend * (1.0 - 0.95 * smoothstep(0.8, 0.9, done));
        // Light damping lets the cloth fall; heavy damping at the end lets it come to rest.
        let keep = if step * 3 < how.steps * 2 { 0.97 } else { 0.85 };
        for i in 0..g.x.len() {
            if weight[i] > 0.0 {
                // The first steps close wide seams; the speed they give is not wanted.
                let keep = if step < 20 { 0.0 } else { keep };
                let mut v = scale(sub(g.x[i], before[i]), keep);
                let fast = norm(v);
                if fast > SPEED {
                    v = scale(v, SPEED / fast);
                }
                before[i] = g.x[i];
                g.x[i] = add(g.x[i], add(v, [0.0, gravity, 0.0]));
            }
        }
        if step >= 20 && how.layer > 0.0 {
            layers.part(&mut g.x, &weight, how.layer);
        }
        for round in 0..16 {
            bends.iter().for_each(|s| pull(&mut g.x, &weight, s, bend, false));
            stretch.iter().for_each(|s| pull(&mut g.x, &weight, s, 0.9, true));
            if round % 5 == 0 {
                collide(g, &weight, &mut before, how);
            }
        }
    }
}

/// Moves the ends of a spring towards its rest length; a bend only pushes.
fn pull(x: &mut [V3], weight: &[f64], s: &Spring, stiffness: f64, both_ways: bool) {
    let [a, b] = s.ends;
    let d = sub(x[b], x[a]);
    let (now, w) = (norm(d), weight[a] + weight[b]);
    if w == 0.0 || now < 1e-9 || (!both_ways && now >= s.rest) {
        return;
    }
    let move_by = scale(d, stiffness * (now - s.rest) / (now * w));
    x[a] = add(x[a], scale(move_by, weight[a]));
    x[b] = sub(x[b], scale(move_by, weight[b]));
}

fn collide(g: &mut Garment, weight: &[f64], before: &mut [V3], how: &Drape) {
    for i in 0..g.x.len() {
        if weight[i] == 0.0 {
            continue;
        }
        let d = how.gap - how.body.distance(g.x[i]);
        if d > 0.0 {
            let n = how.body.outward(g.x[i]);
            g.x[i] = add(g.x[i], scale(n, d));
            let v = sub(g.x[i], before[i]);
            let sideways = sub(v, scale(n, dot(v, n)));
            g.x[i] = sub(g.x[i], scale(sideways, how.friction));
        }
        g.x[i] = (how.limit)(i, g.x[i]);
    }
}

/// Takes the last kinks out: a few Taubin rounds, which smooth without shrinking. Inner particles move along the normal
/// only and rim particles across the rim only, because sliding would spoil the lengths.
pub fn smooth(g: &mut Garment, rounds: usize, pins: &[usize]) {
    let n = g.x.len();
    let mut next: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (t, _) in g.triangles() {
        for k in 0..3 {
            next[t[k]].push(t[(k + 1) % 3]);
            next[t[(k + 1) % 3]].push(t[k]);
        }
    }
    for list in &mut next {
        list.sort_unstable();
        // An inner edge is listed twice, a rim edge once.
        let once: Vec<usize> = list.iter().copied().filter(|j| list.iter().filter(|k| *k == j).count() == 1).collect();
        if once.is_empty() {
            list.dedup();
        } else {
            *list = once;
        }
    }
    let mut fixed = vec![false; n];
    pins.iter().for_each(|&i| fixed[i] = true);
    for factor in [0.5, -0.52].repeat(rounds) {
        let old = g.x.clone();
        let normal = normals(g);
        for i in (0..n).filter(|&i| !fixed[i]) {
            let mean = scale(next[i].iter().fold([0.0; 3], |s, &j| add(s, old[j])), 1.0 / next[i].len() as f64);
            let wish = scale(sub(mean, old[i]), factor);
            let step = if let [a, b] = next[i][..] {
                let along = unit(sub(old[b], old[a]));
                sub(wish, scale(along, dot(wish, along)))
            } else {
                scale(normal[i], dot(wish, normal[i]))
            };
            g.x[i] = add(old[i], step);
        }
    }
}

/// Unit normals of the particles, weighted by area.
pub fn normals(g: &Garment) -> Vec<V3> {
    let mut normal = vec![[0.0; 3]; g.x.len()];
    for (t, _) in g.triangles() {
        let area = cross(sub(g.x[t[1]], g.x[t[0]]), sub(g.x[t[2]], g.x[t[0]]));
        t.iter().for_each(|&i| normal[i] = add(normal[i], area));
    }
    normal.into_iter().map(unit).collect()
}
