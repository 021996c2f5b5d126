//! Cloth that begins inside of a body, of colliders or behind cloth leaves it before the first frame, and nothing jumps in that frame.

use std::sync::Arc;

use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::*;

const FRAME: f64 = 1.0 / 60.0;
const THICKNESS: f32 = 0.003;

/// A closed tube along y of `radius` \[m\] at a height from -0.5 to 0.5 m, with `lower` \[m\] at its lower end.
fn limb(radius: f32, lower: f32) -> BodySurface {
    let (around, rings) = (48u32, 60u32);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..rings {
        let t = j as f32 / (rings - 1) as f32;
        let r = (radius + (lower - radius) * t) * rounded(t);
        for i in 0..around {
            let a = std::f32::consts::TAU * i as f32 / around as f32;
            positions.push([r * a.cos(), 0.5 - t, r * a.sin()]);
        }
    }
    let at = |i: u32, j: u32| j * around + i % around;
    for (i, j) in (0..rings - 1).flat_map(|j| (0..around).map(move |i| (i, j))) {
        triangles.extend([[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]);
    }
    for (j, y) in [(0, 0.5), (rings - 1, -0.5)] {
        let middle = positions.len() as u32;
        positions.push([0.0, y, 0.0]);
        let cap = |i| if j == 0 { [middle, at(i + 1, j), at(i, j)] } else { [middle, at(i, j), at(i + 1, j)] };
        triangles.extend((0..around).map(cap));
    }
    BodySurface::new(positions, triangles, Vec::new()).unwrap()
}

/// How much thinner a limb is at a share of its length, near its ends.
fn rounded(t: f32) -> f32 {
    (1.0 - (2.0 * t - 1.0).powi(8)).max(0.04).sqrt()
}

/// A sleeve around y of `radius` \[m\], of `n` columns, the last one the duplicate of the first, from `top` \[m\] down, its normals outwards.
fn sleeve(name: &str, n: u32, radius: f32, [top, bottom]: [f32; 2]) -> Cloth {
    let rows = n;
    let (mut positions, mut particles) = (Vec::new(), Vec::new());
    for (i, j) in (0..rows).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let angle = std::f32::consts::TAU * (i % (n - 1)) as f32 / (n - 1) as f32;
        positions.push([
            radius * angle.cos(),
            top + (bottom - top) * j as f32 / (rows - 1) as f32,
            radius * angle.sin(),
        ]);
        let other = if i == 0 {
            Some(j * n + n - 1)
        } else if i == n - 1 {
            Some(j * n)
        } else {
            None
        };
        particles.push(Particle::Free { next: other });
    }
    let far = |a: u32, b: u32| {
        let d: f32 = (0..3).map(|c| (positions[a as usize][c] - positions[b as usize][c]).powi(2)).sum();
        d.sqrt()
    };
    let rest = (0..n * rows).map(|k| {
        let (i, j) = (k % n, k / n);
        let to = |ok: bool, other: u32| if ok { far(k, other) } else { 0.0 };
        let (right, down) = (i + 1 < n, j + 1 < rows);
        [to(right, k + 1), to(down, k + n), to(right && down, k + n + 1), to(right && j > 0, (k + 1).wrapping_sub(n))]
    });
    let rest = Rest::Image(rest.collect());
    let grids = vec![Grid { name: name.into(), first: 0, width: n, height: rows }];
    let mass = Mass::Constant(1e-3);
    let mut cloth = Cloth::new(Parts { name: name.into(), grids, positions, particles, rest, mass }).unwrap();
    cloth.thickness = Some(THICKNESS);
    cloth
}

fn scene(cloths: Vec<Cloth>) -> Scene {
    Scene { cloths, ..Scene::new("start") }
}

/// The largest distance \[m\] between where a particle is after the first frame without gravity and where it began.
fn jump(scene: &Scene) -> f64 {
    first_frame(scene, |a, b| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>().sqrt())
}

/// The largest `far` of all particles after the first frame without gravity and where they began.
fn first_frame(scene: &Scene, far: impl Fn(&[f32], &[f32]) -> f64) -> f64 {
    let still = Scene { gravity: [0.0; 3], ..scene.clone() };
    let mut stepper = Stepper::on_cpu(still.clone(), Options::default()).unwrap();
    stepper.advance(FRAME).unwrap();
    let of = |(index, cloth): (usize, &Cloth)| {
        let now = stepper.positions(index).unwrap();
        (0..cloth.len()).map(|k| far(&now[k], &cloth.positions()[k])).fold(0.0, f64::max)
    };
    still.cloths.iter().enumerate().map(of).fold(0.0, f64::max)
}

/// The distance \[m\] from the axis of a limb.
fn across(p: &[f32]) -> f64 {
    f64::from(p[0]).hypot(f64::from(p[2]))
}

fn clear(scene: &mut Scene) -> Vec<ClearedStart> {
    scene.clear_start(&Options::default()).unwrap()
}

/// The height \[m\] of the lowest particle above a limb that is a tube there.
fn lowest(cloth: &Cloth, radius: impl Fn(f32) -> f32) -> f32 {
    let above = |p: &[f32; 3]| (p[0] * p[0] + p[2] * p[2]).sqrt() - radius(p[1]);
    cloth.positions().iter().map(above).fold(f32::INFINITY, f32::min)
}

#[test]
fn a_sleeve_on_an_arm_that_is_a_little_too_large_begins_outside_and_does_not_jump() {
    // Its upper half is inside, by up to 4 mm.
    let radius = |y: f32| (0.108 - 0.016 * (0.5 - y)) * rounded(0.5 - y);
    let mut cloth = sleeve("sleeve", 41, 0.1, [0.3, -0.3]);
    cloth.set_body(Some(Arc::new(limb(0.108, 0.092)))).unwrap();
    let before = scene(vec![cloth]);
    let mut after = before.clone();
    let found = clear(&mut after).remove(0);
    assert!(found.inside > 600 && found.inside < 1100 && found.free == 1640, "{found:?}");
    assert!((0.003..0.006).contains(&found.depth[1]) && found.depth[0] > 0.001, "{found:?}");
    assert!(found.left == 0 && found.pins == 0 && found.moved >= found.inside, "{found:?}");
    // The body is a polygon of 48 sides, whose middles are 0.2 mm within its circle.
    let low = [&before, &after].map(|scene| lowest(&scene.cloths[0], radius));
    assert!(low[0] < -0.0035 && low[1] > 0.0007, "{low:?}");
    let [was, is] = found.stretch.unwrap();
    assert!(was.max < 1e-3 && is.max < 0.06, "no more than the girth asks for, 5 %: {is:?}");
    let text = found.to_string();
    assert!(text.contains("'sleeve'") && text.contains("1640 free") && !text.contains("still inside"), "{text}");

    // It is too tight, so it slides towards the thin end of the arm, but nothing pushes it out.
    let [thrown, clean] = [&before, &after].map(|scene| first_frame(scene, |a, b| (across(a) - across(b)).abs()));
    assert!(thrown > 0.003 && clean < 0.0005, "{thrown:?} {clean:?}");

    // A second time nothing is left to do.
    let again = after.clone();
    assert_eq!(clear(&mut after)[0].moved, 0);
    assert_eq!(after.cloths[0].positions(), again.cloths[0].positions());
}

#[test]
fn cloth_beside_pins_inside_of_a_body_comes_out_by_and_by() {
    // A ring of pins 30 mm inside, and a sleeve that goes on from there inside of the arm, and then outside.
    let mut cloth = sleeve("cape", 41, 0.1, [0.3, -0.3]);
    let radius = |y: f32| if y > 0.1 { 0.07 } else { 0.07 + 0.045 * ((0.1 - y) / 0.4) };
    let placed = cloth.positions().iter().map(|p| {
        let share = radius(p[1]) / 0.1;
        [p[0] * share, p[1], p[2] * share]
    });
    let placed: Vec<_> = placed.collect();
    cloth.place(placed).unwrap();
    cloth.pin(&(0..41).collect::<Vec<_>>()).unwrap();
    cloth.set_body(Some(Arc::new(limb(0.1, 0.1)))).unwrap();
    let before = scene(vec![cloth]);
    let mut after = before.clone();
    let found = clear(&mut after).remove(0);
    assert!(found.pins == 40 && (found.pins_depth - 0.03).abs() < 1e-3, "{found:?}");
    assert!(found.inside > 800 && found.depth[1] > 0.028, "{found:?}");
    // The cloth around the pins stays inside, within 10 cm of them.
    assert!(found.left > 160 && found.left < 320 && found.left_depth < 0.027, "{found:?}");
    assert!(found.to_string().contains("40 pinned particles are inside"), "{found}");
    for (k, p) in after.cloths[0].positions().iter().enumerate() {
        let height = (p[0] * p[0] + p[2] * p[2]).sqrt() - 0.1;
        assert!(k < 41 || height > -0.031 + 0.25 * (0.3 - p[1]) || height > 0.0005, "particle {k}: {height}");
    }

    // In motion springs beside the pins keep their lengths. Without it free particles stay as deep as they were modelled.
    let run = |scene: &Scene| {
        let mut stepper = Stepper::on_cpu(scene.clone(), Options::default()).unwrap();
        let (mut worst, mut deepest) = (0.0f64, 0.0f64);
        for frame in 0..120 {
            stepper.advance(FRAME).unwrap();
            let (now, last) = (stepper.positions(0).unwrap().to_vec(), stepper.previous(0).unwrap().to_vec());
            let health = stepper.examine(0, &now, &last).unwrap();
            if frame > 60 {
                (worst, deepest) = (worst.max(health.stretch.unwrap().max), deepest.max(health.depth));
            }
        }
        (worst, deepest)
    };
    let (stretch, depth) = run(&after);
    assert!(stretch < 0.15 && depth < 0.032, "{stretch} {depth}");
    let jumps = [jump(&before), jump(&after)];
    // It was placed with springs 15 % longer than at rest, which pull.
    assert!(jumps[0] > 0.03 && jumps[1] < 0.5 * jumps[0], "{jumps:?}");
}

#[test]
fn cloth_leaves_colliders_and_what_begins_outside_keeps_its_bits() {
    let sheet = || Flat { origin: [-0.5, 0.0, -0.5], ..Flat::square("sheet", 33) }.cloth().unwrap();
    let mut inside = scene(vec![sheet(), Flat { origin: [5.0; 3], ..Flat::square("far", 9) }.cloth().unwrap()]);
    inside.cloths[0].thickness = Some(THICKNESS);
    inside.colliders.push(Collider::new(Shape::Sphere { radius: 0.15 }, [0.0, -0.12, 0.0]));
    inside.colliders.push(Collider::new(Shape::Box { half: [0.1, 0.02, 0.1] }, [0.3, -0.015, 0.3]));
    let far = inside.cloths[1].clone();
    let before = inside.clone();
    let found = clear(&mut inside);
    assert!(found[0].inside > 40 && found[0].left == 0 && found[0].farthest > 0.025, "{:?}", found[0]);
    assert_eq!((found[1].inside, found[1].moved, found[1].stretch), (0, 0, None));
    assert_eq!(inside.cloths[1], far);
    for p in inside.cloths[0].positions() {
        let d = ((p[0]).powi(2) + (p[1] + 0.12).powi(2) + (p[2]).powi(2)).sqrt();
        assert!(d > 0.15 + THICKNESS - 2e-4, "{p:?}");
    }
    let jumps = [jump(&before), jump(&inside)];
    assert!(jumps[0] > 0.04 && jumps[1] < 0.2 * jumps[0], "{jumps:?}");

    let mut outside = scene(vec![sheet()]);
    outside.cloths[0].set_body(Some(Arc::new(limb(0.1, 0.1)))).unwrap();
    outside.cloths[0].place(sheet().positions().iter().map(|p| [p[0], p[1] + 0.6, p[2]]).collect()).unwrap();
    outside.colliders.push(Collider::new(Shape::HalfSpace, [0.0, -1.0, 0.0]));
    let same = outside.clone();
    clear(&mut outside);
    assert_eq!(outside, same);
}

/// Pairs of triangles that cross.
fn crossed(scene: &Scene) -> u64 {
    crossings::find(&scene.cloths.iter().map(Drawn::new).collect::<Vec<_>>(), 0).unwrap().total()
}

#[test]
fn garments_of_several_layers_begin_one_over_the_other() {
    // A body, a shirt that is partly inside of it, and a jacket that is partly inside of the shirt.
    let body = Arc::new(limb(0.103, 0.099));
    let mut shirt = sleeve("shirt", 41, 0.1, [0.25, -0.25]);
    let mut jacket = sleeve("jacket", 33, 0.104, [0.2, -0.3]);
    // It leans: on one side it is behind the shirt.
    jacket.place(jacket.positions().iter().map(|p| [p[0] + 0.006, p[1], p[2]]).collect()).unwrap();
    for cloth in [&mut shirt, &mut jacket] {
        cloth.set_body(Some(body.clone())).unwrap();
        cloth.contact = Some(ClothContact::default());
    }
    // The jacket comes first in the scene.
    let before = scene(vec![jacket.clone(), shirt.clone()]);
    let mut after = before.clone();
    let found = clear(&mut after);
    assert!(found.iter().all(|of| of.inside > 50 && of.left == 0), "{found:?}");
    assert!(crossed(&before) > 100 && crossed(&after) == 0, "{} {}", crossed(&before), crossed(&after));
    let mean = |cloth: &Cloth| {
        let all = cloth.positions().iter().map(|p| (p[0] * p[0] + p[2] * p[2]).sqrt());
        all.sum::<f32>() / cloth.len() as f32
    };
    assert!(mean(&after.cloths[0]) > mean(&after.cloths[1]) + 0.001, "the jacket is over the shirt");

    // Layers that the host gives count, also against what is measured.
    let mut turned = before.clone();
    turned.cloths[1].contact = Some(ClothContact { layer: 1, ..ClothContact::default() });
    clear(&mut turned);
    let [over, under] = [&turned, &after].map(|scene| mean(&scene.cloths[1]));
    assert!(over > under + 0.001, "{over} {under}");

    // Without contact nothing would keep layers apart.
    let mut apart = before.clone();
    apart.cloths[0].contact = None;
    clear(&mut apart);
    assert!(crossed(&apart) > 100);
}
