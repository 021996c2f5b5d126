//! Impossible beginnings: heaps, disorder, great speed, far away, tiny and huge.

use gimage_runtime::{Cloth, Collider, Result, Shape};

use crate::case::{Asked, Case, N, Stretch, flag, hanging, scene, sheet, tuned};
use crate::random::Random;

pub fn cases() -> Result<Vec<Case>> {
    let mut out = heaps()?;
    out.extend(fast()?);
    for far in [1e3f32, 1e4, 1e5] {
        let cloth = moved(flag()?, |p| [p[0] + far, p[1] + far, p[2] + far])?;
        // At 1e5 m neighbouring numbers of the format are 7.8 mm apart, an eighth of a spring.
        let stretch = if far < 1e5 { Stretch::Judged } else { Stretch::Open };
        out.push(Case::new(format!("{far:.0e} m from the origin"), scene(cloth)).stretch(stretch));
    }
    for size in [1e-3f32, 1e-2, 1e-1, 1e1, 1e2, 1e3] {
        // Under the same gravity the error grows as the cloth shrinks.
        let stretch = if size < 1.0 { Stretch::WithTethers } else { Stretch::Judged };
        let slow = f64::from(size.max(1.0)).sqrt();
        // A larger cloth swings more slowly: the same motion takes so much longer.
        let cloth = tuned(hanging(size)?, |c| c.damping = 2.0 / slow as f32);
        let case = Case::new(format!("scale {size:.0e}, hanging"), scene(cloth)).stretch(stretch);
        // In proportion to the size: at 1 km neighbouring numbers of the format are 0.06 mm apart.
        let asked = Asked { rest: Some(f64::from(size.max(1.0))), ..case.asked };
        out.push(Case { calm: 15.0 * slow, substeps: finer(size), asked, ..case });
    }
    for size in [1e-3f32, 1e-2, 1e-1] {
        let cloth = moved(hanging(size)?, |p| [p[0], 0.0, -p[1]])?;
        let case = Case::new(format!("scale {size:.0e}, falling"), scene(cloth)).stretch(Stretch::WithTethers);
        out.push(Case { substeps: finer(size), ..case });
    }
    Ok(out)
}

/// Substeps for a small cloth: a step's fall must stay a small part of a spring.
fn finer(size: f32) -> u32 {
    (32.0 / size.min(1.0).sqrt()) as u32
}

fn heaps() -> Result<Vec<Case>> {
    let grid = |k: usize| [(k % N) as f32 / 16.0, 0.0, (k / N) as f32 / 16.0];
    let pin = |k: usize| k == 0 || k == N - 1;
    let point = |k: usize| if pin(k) { grid(k) } else { [0.5, 0.0, 0.0] };
    let line = |k: usize| if pin(k) { grid(k) } else { [0.5, -(k as f32) / 289.0, 0.0] };
    let pairs = |k: usize| grid(k - usize::from(k % N == 8));
    let rows = |k: usize| grid(if k / N == 8 { k - N } else { k });
    let random = |half: f64| {
        let mut random = Random(3);
        let list: Vec<_> = (0..N * N).map(|k| if pin(k) { grid(k) } else { random.point(half) }).collect();
        move |k: usize| list[k]
    };
    let close = |k: usize| if pin(k) { grid(k) } else { Random(k as u64).point(1e-6) };
    let mut out = Vec::new();
    let mut case = |words: &str, of: &dyn Fn(usize) -> [f32; 3]| -> Result<()> {
        let mut cloth = flag()?;
        cloth.place((0..N * N).map(of).collect())?;
        out.push(Case::new(words, scene(cloth)));
        Ok(())
    };
    case("two columns coincide", &pairs)?;
    case("two rows coincide", &rows)?;
    case("all at one point but the pins", &point)?;
    case("all at one point, the pins too", &|_| [0.5, 0.0, 0.5])?;
    case("all within a micrometre", &close)?;
    case("all on one line", &line)?;
    case("at random within 1 m", &random(0.5))?;
    case("at random within 100 m", &random(50.0))?;
    case("at random within 1e6 m", &random(5e5))?;
    case("inside out", &|k| if pin(k) { grid(k) } else { grid(N * N - 1 - k) })?;
    Ok(out)
}

fn fast() -> Result<Vec<Case>> {
    let mut out = Vec::new();
    for (words, velocity) in
        [("along itself", [0.0, 0.0, 1e4]), ("across itself", [0.0, -1e4, 0.0]), ("askew", [6e3, 6e3, -6e3])]
    {
        // Damping of 2 /s does not stop within 2 s a motion that springs do not stop: 180 m/s are left.
        let cloth = tuned(flag()?, |c| (c.velocity, c.damping) = (velocity, 8.0));
        out.push(Case::new(format!("1e4 m/s {words}, held, damped at 8 /s"), scene(cloth)));
    }
    let floor = Collider { friction: 0.3, ..Collider::new(Shape::HalfSpace, [0.0, -2.0, 0.0]) };
    let ball = Collider { friction: 0.3, ..Collider::new(Shape::Sphere { radius: 0.3 }, [0.5, -1.0, 0.5]) };
    for (words, colliders) in [("a floor", vec![floor]), ("a ball on a floor", vec![ball, floor])] {
        let cloth = tuned(sheet()?, |c| c.velocity = [0.0, -1e4, 0.0]);
        let scene = gimage_runtime::Scene { colliders, ..scene(cloth) };
        out.push(Case::new(format!("1e4 m/s at {words}"), scene));
    }
    Ok(out)
}

fn moved(mut cloth: Cloth, of: impl Fn([f32; 3]) -> [f32; 3]) -> Result<Cloth> {
    let positions = cloth.positions().iter().map(|p| of(*p)).collect();
    cloth.place(positions)?;
    Ok(cloth)
}
