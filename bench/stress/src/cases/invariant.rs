//! Conserved quantities: momentum of a free cloth, energy of an undamped one.

use gimage_runtime::{Cloth, Collider, Compliance, Flat, Mass, Result, Scene, Shape};

use super::material::with;
use crate::case::{Asked, Case, N, Stretch, held, scene, sheet, tuned};
use crate::random::Random;

const NOTHING: Asked = Asked { stretch: Stretch::Open, rest: None, drift: false, momentum: false, energy: false };

pub fn cases() -> Result<Vec<Case>> {
    let mut out = momentum()?;
    let undamped = |cloth: Cloth| tuned(cloth, |c| c.damping = 0.0);
    let energy = |words: String, scene: Scene, substeps: u32| {
        let case = Case::new(words, scene);
        Case { substeps, calm: 10.0, asked: Asked { energy: true, ..NOTHING }, ..case }
    };
    for substeps in [1, 4, 16, 64] {
        let flag = undamped(held(sheet()?)?);
        out.push(energy(format!("energy, a flag falls, {substeps} substeps"), scene(flag), substeps));
        let curtain = Flat { down: [0.0, -0.8, 0.6], ..Flat::square("cloth", N as u32) };
        let mut curtain = curtain.cloth()?;
        (0..N).try_for_each(|k| curtain.set_pinned(k, true))?;
        out.push(energy(format!("energy, a curtain swings, {substeps} substeps"), scene(curtain), substeps));
        let ball = Collider { friction: 0.3, ..Collider::new(Shape::Sphere { radius: 0.3 }, [0.5, -0.5, 0.5]) };
        let falls = Scene { colliders: vec![ball], ..scene(undamped(sheet()?)) };
        let case = energy(format!("energy, falls on a ball, {substeps} substeps"), falls, substeps);
        out.push(Case { calm: 2.0, ..case });
        let mut soft = tuned(undamped(sheet()?), |c| c.compliance = Compliance::Constant(1e-2));
        let wide = soft.positions().iter().map(|p| p.map(|x| 1.2 * x)).collect();
        soft.place(wide)?;
        let springs = Scene { gravity: [0.0; 3], ..scene(soft) };
        out.push(energy(format!("energy, springs of 0.01 m/N, {substeps} substeps"), springs, substeps));
    }
    Ok(out)
}

fn momentum() -> Result<Vec<Case>> {
    let mut random = Random(5);
    let wide = |cloth: &mut Cloth, by: f32| {
        let positions = cloth.positions().iter().map(|p| p.map(|x| by * x)).collect();
        cloth.place(positions)
    };
    let case = |words: &str, cloth: Cloth| {
        let free = Scene { gravity: [0.0; 3], ..scene(tuned(cloth, |c| c.damping = 0.0)) };
        Case { calm: 5.0, asked: Asked { momentum: true, ..NOTHING }, ..Case::new(words, free) }
    };
    let mut stretched = sheet()?;
    wide(&mut stretched, 1.5)?;
    let mut disorder = sheet()?;
    let list: Vec<_> = (0..N * N).map(|_| random.point(0.5)).collect();
    disorder.place(list)?;
    let any = Mass::Image((0..N * N).map(|_| 1e-4 * 1e6f64.powf(random.unit()) as f32).collect());
    let mut uneven = with(sheet()?, any)?;
    wide(&mut uneven, 1.5)?;
    let soft = tuned(stretched.clone(), |c| c.compliance = Compliance::Constant(1e-3));
    let moving = tuned(stretched.clone(), |c| c.velocity = [3.0, 4.0, 0.0]);
    Ok(vec![
        case("momentum, stretched by half", stretched),
        case("momentum, at random", disorder),
        case("momentum, mass ratio 1e6", uneven),
        case("momentum, 1e-3 m/N", soft),
        case("momentum, at 5 m/s", moving),
    ])
}
