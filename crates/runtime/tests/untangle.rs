//! Contact takes cloth apart that crosses.

use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::*;

const FRAME: f64 = 1.0 / 60.0;
const TIERS: [ContactTier; 2] = [ContactTier::Particles, ContactTier::Safe];

fn options() -> Options {
    Options { threads: 1, normals: false, ..Options::default() }
}

/// A square of 1 m above a table whose left side is at a height of `low` \[m\] and its right side at `high`.
fn tilted(name: &str, n: u32, [low, high]: [f32; 2]) -> Cloth {
    // The front is above.
    let (right, down) = ([1.0, high - low, 0.02], [-0.02, 0.0, -1.0]);
    // Squares that are tilted are not in line with others, so that edges do not meet edges.
    let beside = if low < high { 0.007 } else { 0.0 };
    let mut cloth =
        Flat { origin: [-0.5 + beside, low, 0.5 + beside], right, down, ..Flat::square(name, n) }.cloth().unwrap();
    cloth.damping = 0.5;
    cloth
}

/// Two squares that cross along a line, with contact of a tier in layers.
fn overlap(n: u32, sides: [f32; 2], tier: ContactTier, layers: [i32; 2]) -> Scene {
    let mut scene = Scene::new("overlap");
    for (name, sides, layer) in [("lower", [0.1, 0.1], layers[0]), ("upper", sides, layers[1])] {
        let mut cloth = tilted(name, n, sides);
        cloth.contact = Some(ClothContact { tier, layer, ..ClothContact::default() });
        scene.cloths.push(cloth);
    }
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) });
    scene
}

fn crossings_of(scene: &Scene, stepper: &Stepper) -> u64 {
    let cloths = scene.cloths.iter().enumerate();
    let drawn: Vec<Drawn> =
        cloths.map(|(c, cloth)| Drawn { cloth, positions: stepper.positions(c), holes: stepper.holes(c) }).collect();
    crossings::find(&drawn, 0).unwrap().total()
}

fn height(stepper: &Stepper, cloth: usize) -> f32 {
    let now = stepper.positions(cloth).unwrap();
    now.iter().map(|p| p[1]).sum::<f32>() / now.len() as f32
}

fn bits(stepper: &Stepper) -> Vec<u32> {
    let cloths = 0..stepper.scene().cloths.len();
    let all = cloths.flat_map(|c| [stepper.positions(c).unwrap(), stepper.previous(c).unwrap()]);
    all.flatten().flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn two_hundred_crossings_are_gone_after_a_second_and_stay_away() {
    for tier in TIERS {
        let scene = overlap(64, [0.07, 0.17], tier, [0, 0]);
        let mut stepper = Stepper::on_cpu(scene.clone(), options()).unwrap();
        let start = crossings_of(&scene, &stepper);
        assert!(start > 120, "{start} crossings at the start");
        for frame in 1..=90 {
            stepper.advance(FRAME).unwrap();
            let left = if frame >= 60 { crossings_of(&scene, &stepper) } else { 0 };
            assert_eq!(left, 0, "{tier:?}, frame {frame}");
        }
        let highest = (0..2).flat_map(|c| stepper.positions(c).unwrap()).map(|p| p[1]).fold(0.0, f32::max);
        assert!(highest < 0.3, "{tier:?}: nothing is thrown: {highest} m");
        assert!(height(&stepper, 1) > height(&stepper, 0), "{tier:?}: the larger part has stayed above");
        assert!(!stepper.findings().iter().any(|f| matches!(f.fate, Fate::Tangled { .. })), "{tier:?}");
    }
}

#[test]
fn the_higher_layer_comes_out_on_top_however_much_of_it_is_below() {
    for tier in TIERS {
        // Seven tenths of the second square are below the first one.
        for (layers, above) in [([0, 1], true), ([0, 0], false)] {
            let scene = overlap(32, [0.03, 0.13], tier, layers);
            let mut stepper = Stepper::on_cpu(scene.clone(), options()).unwrap();
            (0..90).for_each(|_| _ = stepper.advance(FRAME).unwrap());
            assert_eq!(crossings_of(&scene, &stepper), 0, "{tier:?} {layers:?}");
            assert_eq!(height(&stepper, 1) > height(&stepper, 0), above, "{tier:?} {layers:?}");
        }
    }
}

/// A square that is folded over, and whose end comes down through it.
fn folded_through(n: u32) -> Scene {
    let mut cloth = tilted("sheet", n, [0.1, 0.1]);
    let over = |p: &[f32; 3]| {
        let along = p[0] + 0.5;
        if along < 0.5 {
            return *p;
        }
        // Up around a half circle of 0.1 m, then back and down.
        let (angle, back) = (((along - 0.5) / 0.05).min(std::f32::consts::PI), (along - 0.5 - 0.157).max(0.0));
        [0.05 * angle.sin() - 0.94 * back, 0.15 - 0.05 * angle.cos() - 0.342 * back, p[2] + 0.003]
    };
    cloth.place(cloth.positions().iter().map(over).collect()).unwrap();
    cloth.contact = Some(ClothContact { tier: ContactTier::Safe, ..ClothContact::default() });
    let mut scene = Scene::new("folded through");
    scene.cloths.push(cloth);
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) });
    scene
}

#[test]
fn cloth_that_passes_through_itself_comes_apart() {
    let scene = folded_through(40);
    let mut stepper = Stepper::on_cpu(scene.clone(), options()).unwrap();
    let start = crossings_of(&scene, &stepper);
    assert!(start > 50, "{start} crossings at the start");
    for frame in 1..=60 {
        stepper.advance(FRAME).unwrap();
        let left = if frame >= 30 { crossings_of(&scene, &stepper) } else { 0 };
        assert_eq!(left, 0, "frame {frame}");
    }
}

#[test]
fn threads_and_saved_states_change_no_bit_while_cloth_is_taken_apart() {
    for tier in TIERS {
        let scene = overlap(24, [0.06, 0.16], tier, [0, 0]);
        let mut one = Stepper::on_cpu(scene.clone(), options()).unwrap();
        let mut three = Stepper::on_cpu(scene.clone(), Options { threads: 3, ..options() }).unwrap();
        for _ in 0..2 {
            one.advance(FRAME).unwrap();
            three.advance(FRAME).unwrap();
        }
        assert!(crossings_of(&scene, &one) > 0, "{tier:?}: it still crosses");
        assert!(bits(&one) == bits(&three), "{tier:?}: threads");
        let saved = one.snapshot().unwrap();
        let mut other = Stepper::on_cpu(scene, options()).unwrap();
        other.restore(&saved).unwrap();
        for frame in 0..20 {
            one.advance(FRAME).unwrap();
            other.advance(FRAME).unwrap();
            assert!(bits(&one) == bits(&other), "{tier:?}, frame {frame}");
        }
    }
}

/// A pin pulls the middle of a square through another one, whose rim is held.
fn pulled(tier: ContactTier) -> (Scene, Stepper) {
    let mut scene = Scene::new("pulled");
    scene.gravity = [0.0; 3];
    for (height, name) in [(0.0, "lower"), (0.06, "upper")] {
        let mut cloth = Flat { origin: [0.0, height, 0.0], ..Flat::square(name, 17) }.cloth().unwrap();
        cloth.damping = 2.0;
        cloth.contact = Some(ClothContact { tier, ..ClothContact::default() });
        scene.cloths.push(cloth);
    }
    let rim = |k: &usize| [k % 17, k / 17].into_iter().any(|line| line == 0 || line == 16);
    (0..289).filter(rim).for_each(|k| scene.cloths[0].set_pinned(k, true).unwrap());
    let middle = 144;
    scene.cloths[1].set_pinned(middle as usize, true).unwrap();
    let mut stepper = Stepper::on_cpu(scene.clone(), options()).unwrap();
    let mut at = stepper.positions(1).unwrap()[middle as usize];
    for _ in 0..15 {
        at[1] -= 0.02;
        stepper.set_pins(1, &[middle], &[[at[0], at[1], at[2]]]).unwrap();
        stepper.advance(FRAME).unwrap();
    }
    assert!(crossings_of(&scene, &stepper) > 0, "{tier:?}: the pin is through");
    stepper.unpin(1, &[middle]).unwrap();
    (scene, stepper)
}

#[test]
fn cloth_that_a_pin_has_pulled_through_cloth_comes_back() {
    for tier in TIERS {
        let (scene, mut stepper) = pulled(tier);
        (0..60).for_each(|_| _ = stepper.advance(FRAME).unwrap());
        assert_eq!(crossings_of(&scene, &stepper), 0, "{tier:?}");
    }
}

/// A square that hangs by two corners brought together, pressed into waves at the start.
fn hung(n: u32) -> Scene {
    let flat = Flat { origin: [0.0, 1.0, 0.0], down: [0.0, -1.0, 0.0], ..Flat::square("sheet", n) };
    let mut cloth = flat.cloth().unwrap();
    cloth.damping = 0.5;
    cloth.place(cloth.positions().iter().map(|p| [0.3 * p[0], p[1], 0.05 * (18.0 * p[0]).sin()]).collect()).unwrap();
    [0, n - 1].into_iter().for_each(|k| cloth.set_pinned(k as usize, true).unwrap());
    cloth.contact = Some(ClothContact { distance: Some(1.2 / (n - 1) as f32), ..ClothContact::default() });
    let mut scene = Scene::new("hung");
    scene.cloths.push(cloth);
    scene
}

#[test]
fn cloth_that_crosses_itself_in_motion_comes_apart_within_a_second() {
    /// Of all frames counted those with crossings.
    fn run(n: u32) -> [u32; 2] {
        let scene = hung(n);
        let mut stepper = Stepper::on_cpu(scene.clone(), options()).unwrap();
        let ([mut crossed, mut counted], mut since) = ([0; 2], 0);
        for frame in (3..=150).step_by(3) {
            (0..3).for_each(|_| _ = stepper.advance(FRAME).unwrap());
            let crosses = crossings_of(&scene, &stepper) > 0;
            since = if crosses { since } else { frame };
            assert!(frame - since <= 60, "{n} particles per side: crossings since frame {since}");
            (crossed, counted) = (crossed + u32::from(crosses), counted + 1);
        }
        [crossed, counted]
    }
    let all = std::thread::scope(|scope| {
        let sizes: Vec<_> = (48..=72).step_by(4).map(|n| scope.spawn(move || run(n))).collect();
        sizes.into_iter().map(|size| size.join().unwrap()).fold([0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]])
    });
    // Without the looks in motion more than half of them do.
    assert!(all[0] > 0 && all[0] * 8 < all[1], "{} of {} frames with crossings", all[0], all[1]);
}

#[test]
fn threads_and_calls_between_frames_change_no_bit_while_cloth_in_motion_comes_apart() {
    let (n, mut crossed) = (60, 0);
    let (scene, pins) = (hung(n), [0, n - 1]);
    let mut stepper = Stepper::on_cpu(scene.clone(), options()).unwrap();
    let mut threads = Stepper::on_cpu(scene.clone(), Options { threads: 3, ..options() }).unwrap();
    for frame in 1..=60 {
        for stepper in [&mut stepper, &mut threads] {
            stepper.advance(FRAME).unwrap();
            let at = stepper.positions(0).unwrap();
            let to = pins.map(|k| [0, 1, 2].map(|c| at[k as usize][c]));
            stepper.set_pins(0, &pins, &to).unwrap();
        }
        assert!(bits(&stepper) == bits(&threads), "frame {frame}");
        crossed += u32::from(frame % 3 == 0 && crossings_of(&scene, &stepper) > 0);
    }
    assert!(crossed > 0, "it does not cross");
}

#[test]
fn cloth_that_does_not_cross_is_stepped_as_without_layers() {
    let run = |layers: [i32; 2]| {
        let scene = overlap(16, [0.15, 0.2], ContactTier::Safe, layers);
        let mut stepper = Stepper::on_cpu(scene, options()).unwrap();
        (0..40).for_each(|_| _ = stepper.advance(FRAME).unwrap());
        bits(&stepper)
    };
    assert!(run([0, 0]) == run([3, -5]));
}
