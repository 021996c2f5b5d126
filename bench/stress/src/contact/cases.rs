//! Disturbances of cloth that touches cloth.

use std::f32::consts::{PI, TAU};

use gimage_runtime::scene::Pose;
use gimage_runtime::{Cloth, Collider, Flat, Grid, Mass, Particle, Parts, Rest, Result, Scene, Shape, Stepper};

/// A scene, and what happens to it.
pub struct Case {
    pub name: &'static str,
    pub scene: Scene,
    /// Length \[s\]; the last second is calm.
    pub seconds: f64,
    /// Contact distance \[m\].
    pub distance: f32,
    /// Whether it is cut.
    pub cuts: bool,
    /// Called before each frame, with the time \[s\] at its end.
    pub during: fn(&Scene, &mut Stepper, f64) -> Result<()>,
}

/// Contact distance over the distance of neighbours: the default, and that of cloth thinner than its cells.
const THICK: f32 = 1.2;
const THIN: f32 = 0.4;

/// All of them.
pub fn all() -> Result<Vec<Case>> {
    let table = Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) };
    Ok(vec![
        squeezed("squeezed between colliders to half its height", table, 0.5)?,
        squeezed("squeezed between colliders to nothing", table, 0.0)?,
        thrown("30 m/s against hanging cloth", Some(hanging(25)?), 25)?,
        thrown("30 m/s against a wall", None, 33)?,
        layers(50, table)?,
        knot()?,
        inside_out()?,
        cut(table)?,
    ])
}

fn still(_: &Scene, _: &mut Stepper, _: f64) -> Result<()> {
    Ok(())
}

fn sheet(flat: Flat) -> Result<Cloth> {
    let mut cloth = flat.cloth()?;
    cloth.damping = 2.0;
    Ok(cloth)
}

/// A square folded to three layers, each 1.3 times the distance of neighbours above the one before.
fn folded(n: u32) -> Result<Cloth> {
    let mut cloth = sheet(Flat::square("sheet", n))?;
    let gap = 1.3 / (n - 1) as f32;
    let bend = PI * gap / 2.0;
    let straight = (1.0 - 2.0 * bend) / 3.0;
    let place = |p: &[f32; 3]| {
        let layer = (p[0] / (straight + bend)).floor().min(2.0);
        let along = p[0] - layer * (straight + bend);
        let angle = ((along - straight) / gap * 2.0).max(0.0);
        let far = along.min(straight) + gap / 2.0 * angle.sin();
        let height = gap * (layer + 1.0) + gap / 2.0 * (1.0 - angle.cos());
        [if layer == 1.0 { straight - far } else { far }, height, p[2]]
    };
    cloth.place(cloth.positions().iter().map(place).collect())?;
    Ok(cloth)
}

/// A plate comes down on a folded square on a table, to a share of its height, stays for a second, and goes up.
fn squeezed(name: &'static str, table: Collider, share: f32) -> Result<Case> {
    let n = 25;
    let spacing = 1.0 / (n - 1) as f32;
    let mut scene = Scene::new(name);
    scene.cloths.push(folded(n)?);
    scene.colliders.push(table);
    let plate = Shape::Box { half: [0.3, 0.1, 0.4] };
    // Its lower face ends at this height; the height of three layers is 3.6 times the distance of neighbours.
    let low = share * 3.6 * spacing + 0.1;
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(plate, [0.17, low + 0.5, 0.5]) });
    let during = |scene: &Scene, stepper: &mut Stepper, seconds: f64| {
        let start = scene.colliders[1].center;
        let down = if seconds < 2.0 { (seconds - 0.5).clamp(0.0, 0.5) } else { (2.5 - seconds).max(0.0) } as f32;
        let position = [start[0], start[1] - down, start[2]];
        stepper.move_collider(1, &Pose { position, ..Pose::default() })
    };
    Ok(Case { name, scene, seconds: 5.0, distance: THICK * spacing, cuts: false, during })
}

fn hanging(n: u32) -> Result<Cloth> {
    let flat = Flat { origin: [-0.5, 1.0, 0.0], down: [0.0, -1.0, 0.0], ..Flat::square("curtain", n) };
    let mut cloth = sheet(flat)?;
    (0..n).try_for_each(|k| cloth.set_pinned(k as usize, true))?;
    Ok(cloth)
}

/// A square at 30 m/s, against other cloth or a wall.
fn thrown(name: &'static str, other: Option<Cloth>, n: u32) -> Result<Case> {
    let mut scene = Scene::new(name);
    scene.cloths.extend(other);
    let at = if scene.cloths.is_empty() { 2.0 } else { 0.6 };
    let flat =
        Flat { origin: [-0.4, 0.9, at], right: [0.8, 0.05, 0.1], down: [0.05, -0.8, 0.1], ..Flat::square("thrown", n) };
    let mut flying = sheet(flat)?;
    flying.velocity = [0.0, 0.0, -30.0];
    scene.cloths.push(flying);
    let wall = [1.0, 0.0, 0.0, 1.0].map(|x: f32| x * std::f32::consts::FRAC_1_SQRT_2);
    // Its normal is +z.
    let at = if scene.cloths.len() > 1 { -2.0 } else { 0.0 };
    scene.colliders.push(Collider { rotation: wall, friction: 0.3, ..Collider::new(Shape::HalfSpace, [0.0, 0.0, at]) });
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0, -0.5, 0.0]) });
    Ok(Case { name, scene, seconds: 5.0, distance: THICK / (n - 1) as f32, cuts: false, during: still })
}

/// Squares dropped on a table, one above the other.
fn layers(count: u32, table: Collider) -> Result<Case> {
    let (name, n) = ("50 layers", 13);
    let mut scene = Scene::new(name);
    let spacing = 1.0 / (n - 1) as f32;
    for layer in 0..count {
        let aside = 0.1 * spacing * (layer as f32 * 2.4).sin();
        let origin = [aside, 1.3 * spacing * (layer + 1) as f32, -aside];
        scene.cloths.push(sheet(Flat { origin, ..Flat::square(&format!("sheet {layer}"), n) })?);
    }
    scene.colliders.push(table);
    Ok(Case { name, scene, seconds: 3.0, distance: THICK * spacing, cuts: false, during: still })
}

/// A ribbon in an overhand knot, whose ends are drawn apart.
fn knot() -> Result<Case> {
    let (name, long, wide) = ("a knotted ribbon is drawn tight", 281u32, 4u32);
    // A. Shastri, "Polynomial representations of knots", 1992.
    let curve = |t: f32| [t * t * t - 3.0 * t, t.powi(4) - 4.0 * t * t, t.powi(5) / 5.0 - 2.0 * t];
    let length = |a: [f32; 3], b: [f32; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
    let fine: Vec<[f32; 3]> = (0..=4000).map(|k| curve(-2.05 + 4.1 * k as f32 / 4000.0)).collect();
    let mut ways = vec![0.0];
    fine.windows(2).for_each(|w| ways.push(ways[ways.len() - 1] + length(w[0], w[1])));
    let whole = ways[ways.len() - 1];
    let spacing = 1.5 / (long - 1) as f32;
    let scale = 1.5 / whole;
    let at = |k: u32| {
        let way = whole * k as f32 / (long - 1) as f32;
        fine[ways.partition_point(|w| *w < way).min(fine.len() - 1)].map(|x| x * scale)
    };
    let flat = Flat {
        name: "ribbon".into(),
        width: long,
        height: wide,
        origin: [0.0; 3],
        right: [1.5, 0.0, 0.0],
        down: [0.0, (wide - 1) as f32 * spacing, 0.0],
        mass: 0.02,
    };
    let mut cloth = sheet(flat)?;
    // The direction across is carried along the curve without a turn around it.
    let mut across = [0.0, 0.0, 1.0];
    let mut rows = Vec::new();
    for k in 0..long {
        let (a, b) = (at(k.saturating_sub(1)), at((k + 1).min(long - 1)));
        let along = unit([0, 1, 2].map(|c| b[c] - a[c]));
        let lean = (0..3).map(|c| across[c] * along[c]).sum::<f32>();
        across = unit([0, 1, 2].map(|c| across[c] - lean * along[c]));
        rows.push((at(k), across));
    }
    let middle = (wide - 1) as f32 / 2.0;
    let place = |k: usize| {
        let (p, across) = rows[k % long as usize];
        let aside = ((k / long as usize) as f32 - middle) * spacing;
        [0, 1, 2].map(|c| p[c] + aside * across[c])
    };
    cloth.place((0..cloth.len()).map(place).collect())?;
    for row in 0..wide {
        for column in [0, long - 1] {
            cloth.set_pinned((row * long + column) as usize, true)?;
        }
    }
    let mut scene = Scene::new(name);
    scene.gravity = [0.0; 3];
    scene.cloths.push(cloth);
    let during = |scene: &Scene, stepper: &mut Stepper, seconds: f64| {
        let cloth = &scene.cloths[0];
        let long = cloth.grids()[0].width;
        let ends = [0, long - 1].map(|column| (0..4).map(|row| row * long + column).collect::<Vec<u32>>());
        let of = |k: u32| cloth.positions()[k as usize];
        let apart = unit([0, 1, 2].map(|c| of(ends[1][0])[c] - of(ends[0][0])[c]));
        for (pins, sign) in ends.iter().zip([-1.0, 1.0]) {
            let way = sign * 0.2 * seconds.min(2.0) as f32;
            let at: Vec<[f32; 3]> = pins.iter().map(|k| [0, 1, 2].map(|c| of(*k)[c] + way * apart[c])).collect();
            stepper.set_pins(0, pins, &at)?;
        }
        Ok(())
    };
    Ok(Case { name, scene, seconds: 4.0, distance: THICK * spacing, cuts: false, during })
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let long = v.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-9);
    v.map(|x| x / long)
}

/// A sleeve whose lower end is gathered and drawn up through it, out at the top. Its layers fit into one another only if they are thin.
fn inside_out() -> Result<Case> {
    let (name, around, rows) = ("a sleeve is turned inside out", 49u32, 33u32);
    let (radius, length) = (0.12, 0.5);
    let spacing = TAU * radius / (around - 1) as f32;
    let positions: Vec<[f32; 3]> = (0..around * rows)
        .map(|k| {
            let (s, c) = (TAU * (k % around % (around - 1)) as f32 / (around - 1) as f32).sin_cos();
            [radius * c, -length * (k / around) as f32 / (rows - 1) as f32, radius * s]
        })
        .collect();
    let particles = (0..around * rows).map(|k| {
        let first = k / around * around;
        let next = if k == first { Some(first + around - 1) } else { (k == first + around - 1).then_some(first) };
        Particle::Free { next }
    });
    let (across, down) = (2.0 * radius * (PI / (around - 1) as f32).sin(), length / (rows - 1) as f32);
    let diagonal = (across * across + down * down).sqrt();
    let parts = Parts {
        name: "sleeve".into(),
        grids: vec![Grid { name: "sleeve".into(), first: 0, width: around, height: rows }],
        particles: particles.collect(),
        rest: Rest::Constant(vec![[across, down, diagonal, diagonal]]),
        mass: Mass::Constant(0.05 / (around * rows) as f32),
        positions,
    };
    let mut cloth = Cloth::new(parts)?;
    cloth.damping = 2.0;
    for column in 0..around {
        cloth.set_pinned(column as usize, true)?;
        cloth.set_pinned(((rows - 1) * around + column) as usize, true)?;
    }
    let mut scene = Scene::new(name);
    scene.gravity = [0.0; 3];
    scene.cloths.push(cloth);
    let during = |scene: &Scene, stepper: &mut Stepper, seconds: f64| {
        let cloth = &scene.cloths[0];
        let (around, rows) = (cloth.grids()[0].width, cloth.grids()[0].height);
        let pins: Vec<u32> = (0..around).map(|column| (rows - 1) * around + column).collect();
        // It is gathered to three quarters of its width in half a second, drawn up by 0.9 m in 3 s, and opened.
        let (gather, up) = ((2.0 * seconds).min(1.0) as f32, 0.3 * (seconds - 0.5).clamp(0.0, 3.0) as f32);
        let open = (seconds - 3.5).clamp(0.0, 1.0) as f32;
        let narrow = 1.0 - 0.25 * (gather - open);
        let at = |k: &u32| {
            let p = cloth.positions()[*k as usize];
            [narrow * p[0], p[1] + up, narrow * p[2]]
        };
        let at: Vec<[f32; 3]> = pins.iter().map(at).collect();
        stepper.set_pins(0, &pins, &at)
    };
    Ok(Case { name, scene, seconds: 6.0, distance: THIN * spacing, cuts: false, during })
}

/// A folded square on a table is cut through all layers.
fn cut(table: Collider) -> Result<Case> {
    let (name, n) = ("cut while it lies folded", 33);
    let mut scene = Scene::new(name);
    scene.cloths.push(folded(n)?);
    scene.colliders.push(table);
    let during = |_: &Scene, stepper: &mut Stepper, seconds: f64| {
        // Once, after a second, along the layers and then across.
        let frame = (seconds * 60.0).round() as u32;
        match frame {
            60 => stepper.cut([0.15, 2.0, 0.5], [-0.5, 0.0, 0.45], [1.0, 0.0, 0.55]),
            90 => stepper.cut([0.15, 2.0, 0.5], [0.12, 0.0, -0.5], [0.2, 0.0, 1.5]),
            _ => Ok(()),
        }
    };
    Ok(Case { name, scene, seconds: 4.0, distance: THICK / (n - 1) as f32, cuts: true, during })
}
