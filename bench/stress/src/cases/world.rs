//! Surroundings of a cloth: colliders, pins, wind, gravity, users.

use gimage_runtime::{Collider, Result, Scene, Shape, Stepper, Wind, WindForce};

use crate::case::{Case, N, Stretch, flag, hanging, scene, sheet};
use crate::random::Random;

pub fn cases() -> Result<Vec<Case>> {
    let mut out = colliders()?;
    out.extend(squeezes()?);
    out.extend(resting()?);
    out.extend(pins()?);
    let none = |s: &mut Stepper| s.set_wind(None);
    for (words, force) in [
        ("particles", WindForce::Push { response: 0.8 }),
        ("triangles", WindForce::Triangles { density: 1.2, drag: 1.0, lift: 0.5 }),
    ] {
        for gust in [0.0, 1.0] {
            let wind = Wind { velocity: [0.0, 20.0, 199.0], gust, gust_size: 0.3, force };
            let storm = move |s: &mut Stepper, _: u32| s.set_wind(Some(wind));
            let words = format!("wind of 200 m/s on {words}, gusts of {gust} rad");
            out.push(Case::new(words, scene(flag()?)).storm(2.0, storm).after(none));
        }
    }
    let heavy =
        |s: &mut Stepper, frame: u32| s.set_gravity([0.0, if frame.is_multiple_of(2) { -9810.0 } else { 9810.0 }, 0.0]);
    let light = |s: &mut Stepper| s.set_gravity([0.0, -9.81, 0.0]);
    out.push(Case::new("1000 g up and down by turns", scene(flag()?)).storm(1.0, heavy).after(light));
    let away = |s: &mut Stepper, frame: u32| {
        let one =
            |x: f32, y: f32, z: f32| [[x, 0.0, 0.0, 0.0], [0.0, x, 0.0, 0.0], [0.0, 0.0, x, 0.0], [0.0, y, z, 1.0]];
        let all: Vec<usize> = (N..N * N).collect();
        s.transform(0, &all, if frame.is_multiple_of(2) { one(-3.0, 1e3, 1e3) } else { one(0.1, 0.0, -1e3) })
    };
    out.push(Case::new("thrown about by users", scene(flag()?)).storm(1.0, away));
    Ok(out)
}

fn colliders() -> Result<Vec<Case>> {
    let gone = |s: &mut Stepper| s.set_colliders(Vec::new());
    let shapes = [
        ("a sphere", Shape::Sphere { radius: 0.3 }),
        ("a capsule", Shape::Capsule { half_height: 0.3, radius: 0.15 }),
        ("a box", Shape::Box { half: [0.3, 0.2, 0.25] }),
        ("an ellipsoid", Shape::Ellipsoid { radii: [0.3, 0.2, 0.25], closest: true }),
        ("a half-space", Shape::HalfSpace),
    ];
    let mut out = Vec::new();
    for (words, shape) in shapes {
        let jump = move |s: &mut Stepper, frame: u32| {
            if !frame.is_multiple_of(5) {
                return Ok(());
            }
            let p = Random(u64::from(frame)).point(0.6);
            let center = [0.5 + p[0], p[1] - 0.5, 0.3 + p[2]];
            s.set_colliders(vec![Collider { friction: 0.3, ..Collider::new(shape, center) }])
        };
        let case = Case::new(format!("{words} teleports and vanishes"), scene(flag()?));
        out.push(case.storm(2.0, jump).after(gone));
    }
    for (words, speed) in [("30 m/s", 30.0f32), ("1e4 m/s", 1e4)] {
        let pass = move |s: &mut Stepper, frame: u32| {
            // There and back, each way in a frame's time of its own speed.
            let sign = if frame.is_multiple_of(2) { 1.0 } else { -1.0 };
            let at = 0.5 * sign * speed / 60.0;
            let shape = Shape::Sphere { radius: 0.3 };
            let moving = Collider::new(shape, [0.5, -0.5, at]);
            s.set_colliders(vec![Collider { velocity: [0.0, 0.0, sign * speed], friction: 0.3, ..moving }])
        };
        let case = Case::new(format!("a sphere passes at {words}"), scene(hanging(1.0)?));
        out.push(case.storm(1.0, pass).after(gone));
    }
    let spin = |s: &mut Stepper, _: u32| {
        let shape = Shape::Box { half: [0.5, 0.05, 0.3] };
        let turning = Collider { spin: [0.0, 0.0, 1e3], friction: 1.0, ..Collider::new(shape, [0.5, -0.6, 0.0]) };
        s.set_colliders(vec![turning])
    };
    out.push(Case::new("a box spins at 1000 rad/s", scene(hanging(1.0)?)).storm(1.0, spin).after(gone));
    let around = Collider::new(Shape::Sphere { radius: 5.0 }, [0.5, 0.0, 0.5]);
    let swallow = move |s: &mut Stepper, _: u32| s.set_colliders(vec![around]);
    out.push(Case::new("a sphere of 5 m around all", scene(flag()?)).storm(1.0, swallow).after(gone));
    Ok(out)
}

fn squeezes() -> Result<Vec<Case>> {
    let mut out = Vec::new();
    let boxes = Shape::Box { half: [0.8, 0.8, 0.2] };
    for (words, shape, reach) in [("boxes", boxes, 0.2f32), ("spheres", Shape::Sphere { radius: 0.4 }, 0.4)] {
        for friction in [0.0, 0.5] {
            let close = move |s: &mut Stepper, frame: u32| {
                // From 0.3 m apart to 0.1 m into each other in 1 s, and held there.
                let gap = 0.15 - 0.2 * (frame as f32 / 60.0).min(1.0);
                let speed = if frame < 60 { 0.2 } else { 0.0 };
                let side = |sign: f32| Collider {
                    friction,
                    velocity: [0.0, 0.0, -sign * speed],
                    ..Collider::new(shape, [0.5, -0.5, sign * (reach + gap)])
                };
                s.set_colliders(vec![side(1.0), side(-1.0)])
            };
            let case = Case::new(format!("squeezed by {words}, friction {friction}"), scene(hanging(1.0)?));
            out.push(case.storm(2.0, close).after(|s| s.set_colliders(Vec::new())));
        }
    }
    Ok(out)
}

fn resting() -> Result<Vec<Case>> {
    let table = Shape::Box { half: [0.3, 0.1, 0.3] };
    let mut out = Vec::new();
    for (words, shape, height) in [
        ("a floor", Shape::HalfSpace, -0.3f32),
        ("a table", table, -0.3),
        ("a ball", Shape::Sphere { radius: 0.4 }, -0.6),
    ] {
        let below = Collider { friction: 0.5, ..Collider::new(shape, [0.5, height, 0.5]) };
        let floor = Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0, -2.0, 0.0]) };
        out.push(Case::new(format!("lies on {words}"), Scene { colliders: vec![below, floor], ..scene(sheet()?) }));
    }
    Ok(out)
}

fn pins() -> Result<Vec<Case>> {
    let corners = [(0, [0.0, 0.0, 0.0]), (N - 1, [1.0f32, 0.0, 0.0])];
    let put = move |s: &mut Stepper, by: [f32; 3], apart: f32| {
        corners
            .iter()
            .try_for_each(|(k, at)| s.set_position(0, *k, [at[0] * apart + by[0], at[1] + by[1], at[2] + by[2]]))
    };
    let home = move |s: &mut Stepper| put(s, [0.0; 3], 1.0);
    let yank = move |s: &mut Stepper, frame: u32| {
        let p = Random(u64::from(frame)).point(5.0);
        if frame.is_multiple_of(6) { put(s, p, 1.0) } else { Ok(()) }
    };
    let tear = move |s: &mut Stepper, _: u32| put(s, [-1.0, 0.0, 0.0], 3.0);
    let far = move |s: &mut Stepper, frame: u32| put(s, [if frame < 30 { 1e4 } else { 0.0 }, 0.0, 0.0], 1.0);
    let blink = |s: &mut Stepper, frame: u32| {
        let k = (Random(u64::from(frame)).unit() * 289.0) as usize;
        s.set_pinned(0, k, frame % 3 != 2)
    };
    let free = |s: &mut Stepper| (0..N * N).try_for_each(|k| s.set_pinned(0, k, k == 0 || k == N - 1));
    Ok(vec![
        Case::new("pins yanked 5 m about", scene(flag()?)).storm(2.0, yank).after(home),
        Case::new("pins pulled 3 m apart", scene(flag()?)).storm(2.0, tear).after(home),
        Case::new("pins 1e4 m away and back", scene(flag()?)).storm(1.0, far).after(home),
        Case::new("pins come and go at random", scene(flag()?)).storm(2.0, blink).after(free).stretch(Stretch::Judged),
    ])
}
