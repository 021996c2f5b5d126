use super::hung::{HANG_POLISH, STRIP_POLISH, WHIP_POLISH};
use super::*;
use crate::cloth::{Flat, Influence, Particle, Parts, Rest, SkinJoint};
use crate::collider::{Collider, Shape};
use crate::scene::builtin;

fn chosen(scene: &Scene, given: Options) -> Choice {
    Settings::new(given, scene).1
}

#[test]
fn given_numbers_win_over_every_rule() {
    for name in ["s1", "s2", "s2f", "s3"] {
        let scene = builtin(name, 32).unwrap();
        let given = Options { substeps: Some(3), polish: Some(0), ..Options::default() };
        let (settings, choice) = Settings::new(given.clone(), &scene);
        assert_eq!((settings.substeps, settings.polish, settings.given()), (3, 0, &given), "{name}");
        assert!(choice.to_string().ends_with(": given"), "{choice}");
        let [one, other, none] = [(None, Some(2)), (Some(9), None), (None, None)]
            .map(|(substeps, polish)| chosen(&scene, Options { substeps, polish, ..Options::default() }));
        assert_eq!((one.substeps, one.polish), (none.substeps, 2), "{name}");
        assert_eq!((other.substeps, other.polish), (9, 0), "{name}");
    }
}

#[test]
fn support_size_and_speed_decide() {
    let of = |name: &str, n| chosen(&builtin(name, n).unwrap(), Options::default());
    assert_eq!(of("s1", 32).support, Support::Stirred, "it swings down");
    assert!(matches!(of("s2", 32).support, Support::Falls(v) if v > 1.9 && v < 2.1));
    assert!(matches!(of("s2f", 32).support, Support::Fast(v) if v > 30.0 && v < 33.0));
    let mut lying = builtin("s2", 64).unwrap();
    lying.colliders[0].center[1] = 0.2;
    let lying = chosen(&lying, Options::default());
    assert_eq!((lying.substeps, lying.polish, lying.support), (12, 8, Support::OnColliders));
    let hung = chosen(&curtain(64), Options::default());
    assert!(of("s2", 64).substeps > lying.substeps && lying.substeps > hung.substeps);
    assert!(of("s2", 128).substeps > of("s2", 64).substeps);
    let half = chosen(&builtin("s2", 64).unwrap(), Options { step: 1.0 / 120.0, ..Options::default() });
    assert_eq!(half.substeps, of("s2", 64).substeps.div_ceil(2));
    // Soft springs that nobody sees give have no polish, and those that give have as many relaxations as show it.
    let mut stiffer = builtin("s1k", 32).unwrap();
    stiffer.cloths[0].compliance = Compliance::Constant(1e-5);
    let stiffer = chosen(&stiffer, Options::default());
    assert_eq!((stiffer.substeps, stiffer.polish), (FREE_SUBSTEPS, 0));
    assert_eq!([of("s1k", 32), of("s1k", 256)].map(|c| (c.substeps, c.polish)), [(64, 1); 2]);
    let classic = chosen(&builtin("s2", 64).unwrap(), Options { solver: Solver::Classic, ..Options::default() });
    assert_eq!((classic.substeps, classic.polish), (FREE_SUBSTEPS, 0));
    let words = of("s2", 64).to_string();
    assert!(words.contains("substeps") && words.contains("cloth 's2' falls on colliders at 2.0 m/s"), "{words}");
}

/// A square that hangs in the plane of gravity from two corners.
fn curtain(n: u32) -> Scene {
    let mut cloth = Flat { down: [0.0, -1.0, 0.0], ..Flat::square("curtain", n) }.cloth().unwrap();
    [0, n - 1].into_iter().for_each(|k| cloth.set_pinned(k as usize, true).unwrap());
    cloth.damping = 1.0;
    let mut scene = Scene::new("curtain");
    scene.cloths.push(cloth);
    scene
}

#[test]
fn hanging_cloth_that_is_stirred_has_more_substeps() {
    let of = |scene: &Scene| {
        let choice = chosen(scene, Options::default());
        (choice.substeps, choice.stirred, choice.polish, choice.support)
    };
    let calm = curtain(64);
    assert_eq!(of(&calm), (4, 21, HANG_POLISH, Support::Tethered));
    let words = chosen(&calm, Options::default()).to_string();
    assert!(words.starts_with("4 substeps, 21 while wind or its pins stir the cloth, 2 rounds of polish"), "{words}");
    let wind = |speed: f32| {
        let force = crate::WindForce::Push { response: 1.0 };
        Some(crate::Wind { velocity: [0.0, 0.0, speed], gust: 0.0, gust_size: 1.0, force })
    };
    assert_eq!(of(&Scene { wind: wind(1.0), ..calm.clone() }), of(&calm));
    assert_eq!(of(&Scene { wind: wind(8.0), ..calm.clone() }), (21, 21, HANG_POLISH, Support::Stirred));
    // Cloth that lies at the start swings down, without gravity it does not.
    let lying = builtin("s1", 64).unwrap();
    assert_eq!(of(&lying), (21, 21, HANG_POLISH, Support::Stirred));
    assert_eq!(of(&Scene { gravity: [0.0; 3], ..lying }).3, Support::Tethered);
    // Rounds take the place of substeps, to a degree.
    let mut whipping = calm.clone();
    whipping.cloths[0].damping = 0.0;
    assert_eq!(of(&whipping), (4, 9, WHIP_POLISH, Support::Tethered));
    // A material has no rounds, and is stirred among colliders, too.
    let ball = Collider::new(Shape::Sphere { radius: 0.1 }, [0.0, -5.0, 0.0]);
    let mut cotton = calm.clone();
    cotton.cloths[0].set_material(&crate::Material::named("cotton").unwrap()).unwrap();
    assert_eq!(of(&cotton), (8, 40, 0, Support::Tethered));
    cotton.colliders = vec![ball];
    assert_eq!(of(&cotton), (16, 40, 0, Support::TetheredOnColliders));
    // Numbers that were given stay.
    let given = Options { substeps: Some(4), ..Options::default() };
    let windy = Scene { wind: wind(8.0), ..calm.clone() };
    assert_eq!((chosen(&windy, given.clone()).substeps, chosen(&windy, given).stirred), (4, 0));
    // Other supports have their own rules.
    assert_eq!(of(&Scene { colliders: vec![ball], ..windy }).3, Support::TetheredOnColliders);
}

#[test]
fn cloth_that_is_spanned_between_pins_has_more_substeps_and_all_its_tethers() {
    let mut canopy = builtin("s1", 64).unwrap();
    [64 * 63, 64 * 64 - 1].into_iter().for_each(|k| canopy.cloths[0].set_pinned(k, true).unwrap());
    let (settings, choice) = Settings::new(Options::default(), &canopy);
    assert_eq!((choice.support, choice.polish), (Support::Stirred, 4), "{choice}");
    assert_eq!(settings.hold, [Hold { most: 4, slack: 1.0 }]);
    // Nothing stirs it without gravity.
    let calm = chosen(&Scene { gravity: [0.0; 3], ..canopy.clone() }, Options::default());
    assert_eq!((calm.substeps, calm.stirred, calm.support), (8, 13, Support::Spanned));
    assert!(calm.to_string().ends_with("is spanned between pins"), "{calm}");
    // A row needs one tether, pins on a line two, and none has more than the host allows.
    let most = |name, tethers| {
        let given = Options { tethers, ..Options::default() };
        Settings::new(given, &builtin(name, 64).unwrap()).0.hold[0].most
    };
    assert_eq!([most("s3", 4), most("s3", 0), most("s1", 4), most("s1", 1)], [1, 0, 2, 1]);
    // A canopy of cotton sags by a ninth of its side, which takes 1 to 2 % of length.
    canopy.cloths[0].set_material(&crate::Material::named("cotton").unwrap()).unwrap();
    let cotton = Settings::new(Options::default(), &canopy).0.hold[0];
    assert!((1.01..1.02).contains(&cotton.slack), "{cotton:?}");
    // One that is too soft to hold itself is held by its tethers.
    let soft = crate::Material { warp: 1e-3, weft: 1e-3, shear: 1e-4, ..crate::Material::default() };
    canopy.cloths[0].set_material(&soft).unwrap();
    assert_eq!(Settings::new(Options::default(), &canopy).0.hold[0].slack, 1.0);
}

#[test]
fn garments_have_numbers_of_their_own() {
    let garment = |pins: u32| {
        let curtain = curtain(64);
        let sheet = &curtain.cloths[0];
        let rest = Rest::Image((0..64 * 64).map(|k| std::array::from_fn(|d| sheet.spring(0, k, d))).collect());
        let pinned = |k: u32| if k < pins { Particle::Pinned { next: None } } else { Particle::Free { next: None } };
        let (positions, particles) = (sheet.positions().to_vec(), (0..64 * 64).map(pinned).collect());
        let (grids, mass) = (sheet.grids().to_vec(), crate::Mass::Constant(1e-4));
        let parts = Parts { name: "garment".into(), grids, positions, particles, rest, mass };
        let mut cloth = Cloth::new(parts).unwrap();
        cloth.damping = 1.0;
        cloth
    };
    let of = |cloth: Cloth| {
        let choice = chosen(&Scene { cloths: vec![cloth], ..Scene::new("") }, Options::default());
        (choice.substeps, choice.stirred, choice.polish, choice.support)
    };
    assert_eq!(of(garment(4)), (5, 13, 4, Support::Tethered));
    assert_eq!(of(garment(64)), (16, 24, 4, Support::TetheredRow));
    let mut cotton = garment(4);
    cotton.set_material(&crate::Material::named("cotton").unwrap()).unwrap();
    assert_eq!(of(cotton), (24, 40, 0, Support::Tethered));
}

#[test]
fn substeps_follow_what_stirs_hanging_cloth() {
    let scene = curtain(64);
    let (settings, choice) = Settings::new(Options::default(), &scene);
    let mut follow = Follow::new(&settings, &scene);
    let mut now = choice.substeps;
    let mut frames = |follow: &mut Follow, count: u32, stirs: bool| {
        for _ in 0..count {
            if stirs {
                follow.stir();
            }
            now = follow.next(now, &scene);
            follow.stepped(1.0 / 60.0);
        }
        now
    };
    assert_eq!(frames(&mut follow, 10, false), 4);
    assert_eq!(frames(&mut follow, 1, true), 21, "at once");
    assert_eq!(frames(&mut follow, 200, true), 21);
    assert_eq!(frames(&mut follow, 55, false), 21, "a while longer");
    assert_eq!(frames(&mut follow, 60, false), 4);
    // A sheet of 1 m that swings down is stirred for a period of 1.95 s, and held for one second more.
    let lying = builtin("s1", 64).unwrap();
    let (settings, choice) = Settings::new(Options::default(), &lying);
    let mut follow = Follow::new(&settings, &lying);
    let mut counts = vec![choice.substeps];
    for _ in 0..240 {
        counts.push(follow.next(counts[counts.len() - 1], &lying));
        follow.stepped(1.0 / 60.0);
    }
    assert_eq!((counts[175], counts[210]), (21, 4), "{counts:?}");
}

#[test]
fn large_cloth_that_swings_down_is_stirred_for_longer() {
    let lying = |side: f32| {
        let sheet = Flat { right: [side, 0.0, 0.0], down: [0.0, 0.0, side], ..Flat::square("sheet", 16) };
        hung::swing_time(&sheet.cloth().unwrap(), [0.0, -9.81, 0.0])
    };
    let one = lying(1.0);
    assert!((one - 1.948).abs() < 1e-3 && (lying(4.0) - 2.0 * one).abs() < 1e-6, "{one} {}", lying(4.0));
    assert_eq!([lying(0.05), lying(100.0)], [1.0, 5.0]);
    let hanging = Flat { down: [0.0, -1.0, 0.0], ..Flat::square("sheet", 16) }.cloth().unwrap();
    assert_eq!(hung::swing_time(&hanging, [0.0, -9.81, 0.0]), 0.0);
}

#[test]
fn strips_that_swing_from_a_corner_have_more_rounds() {
    let of = |width, height| {
        let mut scene = builtin("s1", 32).unwrap();
        let mut cloth = Flat { width, height, ..Flat::square("hung", 32) }.cloth().unwrap();
        cloth.set_pinned(0, true).unwrap();
        cloth.damping = 2.0;
        scene.cloths = vec![cloth];
        chosen(&scene, Options::default()).polish
    };
    assert_eq!([of(60, 60), of(94, 30), of(94, 8), of(8, 94)], [HANG_POLISH, HANG_POLISH, STRIP_POLISH, STRIP_POLISH]);
}

#[test]
fn a_collider_that_speeds_up_raises_the_number_at_once_and_lets_it_fall_gradually() {
    let mut scene = builtin("s2", 32).unwrap();
    let (settings, choice) = Settings::new(Options::default(), &scene);
    let mut follow = Follow::new(&settings, &scene);
    let rest = choice.substeps;
    assert_eq!(follow.next(rest, &scene), rest);
    let ball = Collider::new(Shape::Sphere { radius: 0.1 }, [0.0; 3]);
    scene.colliders = vec![Collider { velocity: [30.0, 0.0, 0.0], ..ball }];
    let fast = follow.next(rest, &scene);
    assert!(fast > 2 * rest, "{fast} {rest}");
    scene.colliders = vec![ball];
    let mut counts = vec![fast];
    for _ in 0..120 {
        follow.stepped(1.0 / 60.0);
        counts.push(follow.next(counts[counts.len() - 1], &scene));
    }
    assert_eq!((counts[50], counts[120]), (fast, rest));
    assert!(counts.windows(2).all(|n| n[0] - n[1] <= n[0].div_ceil(8)), "{counts:?}");
    // A number that was given stays.
    let given = Options { substeps: Some(5), ..Options::default() };
    let settings = Settings::new(given, &scene).0;
    scene.colliders = vec![Collider { velocity: [30.0, 0.0, 0.0], ..ball }];
    assert_eq!(Follow::new(&settings, &scene).next(5, &scene), 5);
}

#[test]
fn the_finer_the_grid_and_the_stiffer_the_fabric_the_more_substeps() {
    let of = |name: &str, n: u32| {
        let mut scene = curtain(n);
        scene.cloths[0].set_material(&crate::Material::named(name).unwrap()).unwrap();
        chosen(&scene, Options::default()).substeps
    };
    assert_eq!((of("silk", 32), of("felt", 32)), (FREE_SUBSTEPS, FREE_SUBSTEPS));
    let fine = ["silk", "denim", "felt"].map(|name| of(name, 128));
    assert!(fine.is_sorted() && fine[0] > FREE_SUBSTEPS && fine[2] > 40, "{fine:?}");
    assert_eq!(of("felt", 256), MAX_SUBSTEPS);
    // Cells half as long need four times the steps.
    let [coarse, half] = [96, 191].map(|n| f64::from(of("silk", n)));
    assert!(half > 2.0 * coarse && half <= 4.0 * coarse + 1.0, "{coarse} {half}");
}

#[test]
fn a_pyramid_takes_the_place_of_substeps_where_springs_alone_hold_cloth() {
    let scene = builtin("s1", 128).unwrap();
    let of = |scene: &Scene, pyramid| chosen(scene, Options { tethers: 0, pyramid, ..Options::default() });
    assert_eq!([of(&scene, 0), of(&scene, 3)].map(|c| (c.substeps, c.polish)), [(23, 4), (10, 4)]);
    // No pyramid runs for cloth that meets colliders.
    let mut among = scene.clone();
    among.colliders = vec![Collider::new(Shape::Sphere { radius: 0.1 }, [0.0, -5.0, 0.0])];
    assert_eq!(of(&among, 3).substeps, of(&among, 0).substeps);
}

/// A square of 64 x 64 particles that hangs by its upper row, on a joint or not, among a ball at rest and one that moves.
fn worn(joint: bool, [small, large]: [f32; 2], speed: f32) -> Scene {
    let mut cloth = Flat::square("skirt", 64).cloth().unwrap();
    (0..64).for_each(|k| cloth.set_pinned(k, true).unwrap());
    if joint {
        let hip = SkinJoint { name: "hip".into(), parent: None, inverse_bind: STILL };
        let of = vec![Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; 64 * 64];
        cloth.set_skin(vec![hip], &of).unwrap();
        cloth.follow_joints(&[STILL]).unwrap();
    }
    let ball = |radius: f32, x: f32| Collider::new(Shape::Sphere { radius }, [x, -0.5, 0.0]);
    let mut scene = Scene::new("worn");
    scene.cloths.push(cloth);
    scene.colliders.extend([ball(small, 2.0), Collider { velocity: [0.0, 0.0, speed], ..ball(large, 4.0) }]);
    scene
}

const STILL: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

#[test]
fn a_thin_collider_at_rest_does_not_make_a_thick_one_fast() {
    let of = |radii, speed| chosen(&worn(false, radii, speed), Options::default());
    let slow = of([0.005, 0.3], 3.0);
    assert_eq!((slow.substeps, slow.support), (12, Support::TetheredOnColliders));
    // 3 m/s are 5 cm in a frame, and the steps of a ball of 1 cm are of 1 mm.
    let fast = of([0.3, 0.01], 3.0);
    assert!((50..52).contains(&fast.substeps) && matches!(fast.support, Support::Fast(_)), "{fast}");
}

#[test]
fn worn_cloth_has_fewer_steps_the_nearer_its_pins_are() {
    let of = |joint, speed| chosen(&worn(joint, [0.3, 0.1], speed), Options::default());
    let cape = of(true, 0.0);
    assert_eq!((cape.substeps, cape.polish, cape.support), (12, CAPE_POLISH, Support::Worn));
    assert!(cape.to_string().contains("cloth 'skirt' hangs from the joints of a body"), "{cape}");
    let mut skirt = worn(true, [0.3, 0.1], 0.0);
    (0..32).for_each(|row| skirt.cloths[0].set_pinned(64 * row, true).unwrap());
    (0..32 * 64).for_each(|k| skirt.cloths[0].set_pinned(k, true).unwrap());
    let skirt = chosen(&skirt, Options::default());
    assert_eq!((skirt.substeps, skirt.polish), (8, WORN_POLISH));
    // A collider may go two and a half times as far past it.
    assert_eq!([false, true].map(|joint| of(joint, 24.0).substeps), [40, 16]);
}
