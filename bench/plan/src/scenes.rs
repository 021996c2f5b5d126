//! One scene for each feature, beside the plain one without any.

use gimage_runtime::{
    BodySurface, Cloth, ClothContact, Collider, Compliance, Flat, Grid, Mass, Material, Options, Particle, Parts, Rest,
    Result, Scene, Shape, Sleep, Solver, Wind, WindForce,
};

/// Change made to a scene before it is timed.
#[derive(Clone, Copy)]
pub enum Action {
    /// Nothing.
    None,
    /// It is cut across.
    Cut,
    /// Its first cloth is put to sleep.
    Sleep,
}

/// A scene by name.
pub struct Case {
    /// Its name in the table.
    pub name: &'static str,
    /// It.
    pub scene: Scene,
    /// Change made to it.
    pub action: Action,
    /// Its settings, but for those of the run: backend and substeps.
    pub options: Options,
}

impl Case {
    /// With other settings.
    fn with(mut self, set: impl FnOnce(&mut Options)) -> Self {
        set(&mut self.options);
        self
    }

    /// After something is done.
    fn after(self, action: Action) -> Self {
        Case { action, ..self }
    }
}

/// One that nothing is asked of: no tethers and, by `solver`, nothing of XPBD.
fn case(name: &'static str, solver: Solver, scene: Scene) -> Case {
    let options = Options { solver, tethers: 0, ..Options::default() };
    Case { name, scene, action: Action::None, options }
}

/// All cases of `n` x `n` particles; the first of each solver is its plain one.
pub fn cases(n: u32) -> Result<Vec<Case>> {
    let mut cases = shared(n, Solver::Classic, "")?;
    let two = Scene { cloths: vec![square(n)?, square(n)?], ..plain(n)? };
    cases.push(case("two cloths", Solver::Classic, two.clone()));
    cases.push(case("two cloths and one asleep", Solver::Classic, two).after(Action::Sleep));
    cases.extend(shared(n, Solver::Xpbd, "xpbd")?);
    cases.extend(xpbd(n)?);
    Ok(cases)
}

/// A body at rest beneath the cloth: a ball of 64 x 32 cells.
fn round_body() -> Result<BodySurface> {
    let (around, rings) = (64u32, 33u32);
    let at = |k: u32| {
        let (a, t) = (std::f32::consts::TAU * (k % around) as f32, std::f32::consts::PI * (k / around) as f32);
        let (a, t) = (a / around as f32, t / (rings - 1) as f32);
        [0.5 + 0.25 * t.sin() * a.cos(), -0.2 + 0.25 * t.cos(), 0.5 + 0.25 * t.sin() * a.sin()]
    };
    let corner = |i: u32, j: u32| j * around + i % around;
    let cells = (0..rings - 1).flat_map(|j| (0..around).map(move |i| (i, j)));
    let two = |(i, j)| {
        let [a, b] = [corner(i, j), corner(i + 1, j)];
        [[a, b, corner(i, j + 1)], [b, corner(i + 1, j + 1), corner(i, j + 1)]]
    };
    BodySurface::new((0..around * rings).map(at).collect(), cells.flat_map(two).collect(), Vec::new())
}

fn plain(n: u32) -> Result<Scene> {
    Ok(Scene { cloths: vec![square(n)?], ..Scene::new("plain") })
}

/// Cases that both solvers have; names begin with `of`, where that is not empty.
fn shared(n: u32, solver: Solver, of: &str) -> Result<Vec<Case>> {
    let name = |words: &'static str| -> &'static str {
        match (of, words) {
            ("", "") => "plain",
            ("", words) => words,
            (of, "") => Box::leak(of.to_owned().into_boxed_str()),
            (of, words) => Box::leak(format!("{of}: {words}").into_boxed_str()),
        }
    };
    let case = |words, scene| case(name(words), solver, scene);
    let plain = || plain(n);
    let rest = |rest| -> Result<Scene> { Ok(Scene { cloths: vec![other(n, rest, false)?], ..plain()? }) };
    let lengths = lengths(n)?;
    let image = vec![lengths; (n * n) as usize];
    let seamed = Scene { cloths: vec![other(n, Rest::Image(image.clone()), true)?], ..plain()? };
    let mut cases = vec![
        case("", plain()?),
        case("without normals", plain()?).with(|o| o.normals = false),
        case("no springs", rest(Rest::None)?),
        case("no shear", rest(Rest::Constant(vec![[lengths[0], lengths[1], 0.0, 0.0]]))?),
        case("an image of rest lengths", rest(Rest::Image(image))?),
        case("an image and a seam", seamed),
    ];
    for (words, shape) in shapes() {
        let touching = Collider::new(shape, [0.5, -0.2, 0.5]);
        cases.push(case(words, Scene { colliders: vec![touching], ..plain()? }));
    }
    let all: Vec<_> = shapes().map(|(_, shape)| Collider::new(shape, [0.5, -0.2, 0.5])).into();
    let rough = all.iter().map(|c| Collider { friction: 0.3, ..*c }).collect();
    cases.push(case("all six colliders", Scene { colliders: all, ..plain()? }));
    cases.push(case("all six with friction", Scene { colliders: rough, ..plain()? }));
    let push = WindForce::Push { response: 0.8 };
    let triangles = WindForce::Triangles { density: 1.2, drag: 1.0, lift: 0.5 };
    for (words, force) in [("wind on particles", push), ("wind on triangles", triangles)] {
        let wind = Wind { velocity: [2.0, 0.3, 1.0], gust: 1.0, gust_size: 0.3, force };
        cases.push(case(words, Scene { wind: Some(wind), ..plain()? }));
    }
    cases.push(case("cut", plain()?).after(Action::Cut));
    // Falling cloth is never calm: what is timed is the watching.
    cases.push(case("watched for rest", plain()?).with(|o| o.sleep = Some(Sleep::default())));
    cases.push(case("asleep", plain()?).after(Action::Sleep));
    Ok(cases)
}

/// Cases that only the solver XPBD has.
fn xpbd(n: u32) -> Result<Vec<Case>> {
    let case = |name, scene| case(name, Solver::Xpbd, scene);
    let plain = || plain(n);
    let of = |set: &dyn Fn(&mut Cloth) -> Result<()>| -> Result<Scene> {
        let mut cloth = square(n)?;
        set(&mut cloth)?;
        Ok(Scene { cloths: vec![cloth], ..plain()? })
    };
    let soft = |compliance: Compliance| {
        of(&move |cloth| {
            cloth.compliance = compliance.clone();
            Ok(())
        })
    };
    let fabric = |bend| of(&move |cloth| cloth.set_material(&Material { bend, ..Material::default() }));
    let with = |colliders| -> Result<Scene> { Ok(Scene { colliders, ..plain()? }) };
    let ball = |center| Collider::new(Shape::Sphere { radius: 0.25 }, center);
    let touching = ball([0.5, -0.2, 0.5]);
    let far: Vec<_> = (0..100).map(|k| ball([k as f32, 50.0, 0.0])).collect();
    let all: Vec<_> = shapes().map(|(_, shape)| Collider::new(shape, [0.5, -0.2, 0.5])).into();
    let rough: Vec<_> = all.into_iter().map(|c| Collider { friction: 0.3, ..c }).collect();
    let moving = Collider { velocity: [0.0, 0.1, 0.0], ..touching };
    let one = Compliance::Constant(1e-3);
    let image = Compliance::Image(vec![[1e-3; 4]; (n * n) as usize].into());
    let many = || -> Result<Scene> { Ok(Scene { cloths: vec![square(n)?; 64], ..plain()? }) };
    let apart = |name, scene| case(name, scene).with(|o| o.fused = false);
    let worn = of(&|cloth| cloth.set_body(Some(round_body()?.into())))?;
    Ok(vec![
        case("on the surface of a body", worn),
        apart("xpbd in separate passes", plain()?),
        case("64 cloths", many()?),
        apart("64 cloths in separate passes", many()?),
        case("xpbd with 1 tether", plain()?).with(|o| o.tethers = 1),
        case("xpbd with 2 tethers", plain()?).with(|o| o.tethers = 2),
        apart("xpbd with 2 tethers in separate passes", plain()?).with(|o| o.tethers = 2),
        case("xpbd with 2 tethers and a cut", plain()?).with(|o| o.tethers = 2).after(Action::Cut),
        case("xpbd with 2 tethers and a round of polish", plain()?).with(|o| (o.tethers, o.polish) = (2, Some(1))),
        case("xpbd with a pyramid once in 2 steps", plain()?).with(|o| o.pyramid = 2),
        case(
            "xpbd with a pyramid and a seam",
            Scene { cloths: vec![other(n, Rest::Constant(vec![lengths(n)?]), true)?], ..plain()? },
        )
        .with(|o| o.pyramid = 2),
        case(
            "xpbd with contact of cloth with cloth",
            of(&|cloth| {
                cloth.contact = Some(ClothContact::default());
                Ok(())
            })?,
        ),
        case("xpbd with compliance", soft(one.clone())?),
        case("xpbd with an image of compliance", soft(image)?),
        case("xpbd with a material that does not bend", fabric(0.0)?),
        case("xpbd with a material that bends", fabric(1e-5)?),
        case("xpbd with 2 relaxations", plain()?).with(|o| o.iterations = 2),
        apart("xpbd with 2 relaxations in separate passes", plain()?).with(|o| o.iterations = 2),
        case("xpbd with compliance and 2 relaxations", soft(one)?).with(|o| o.iterations = 2),
        case("xpbd with a sphere", with(vec![touching])?),
        case("xpbd with a sphere that moves", with(vec![moving])?),
        case("xpbd with a sphere out of reach", with(far[..1].to_vec())?),
        case("xpbd with 100 spheres out of reach", with(far.clone())?),
        apart("xpbd with 100 spheres out of reach in separate passes", with(far)?),
        case("xpbd with all six and friction", with(rough.clone())?),
        apart("xpbd with all six and friction in separate passes", with(rough)?),
    ])
}

fn shapes() -> [(&'static str, Shape); 6] {
    let radii = [0.3, 0.2, 0.25];
    [
        ("a half-space", Shape::HalfSpace),
        ("a sphere", Shape::Sphere { radius: 0.25 }),
        ("a capsule", Shape::Capsule { half_height: 0.2, radius: 0.2 }),
        ("a box", Shape::Box { half: [0.3, 0.2, 0.25] }),
        ("an ellipsoid (radial)", Shape::Ellipsoid { radii, closest: false }),
        ("an ellipsoid (closest)", Shape::Ellipsoid { radii, closest: true }),
    ]
}

/// A horizontal square of 1 m, held at two corners.
fn square(n: u32) -> Result<Cloth> {
    let mut cloth = Flat::square("square", n).cloth()?;
    cloth.set_pinned(0, true)?;
    cloth.set_pinned(n as usize - 1, true)?;
    Ok(cloth)
}

fn lengths(n: u32) -> Result<[f32; 4]> {
    Ok(match square(n)?.rest() {
        Rest::Constant(lengths) => lengths[0],
        _ => [0.0; 4],
    })
}

/// The square with other springs; with a seam, rolled up to a tube whose first and last column are one.
fn other(n: u32, rest: Rest, seam: bool) -> Result<Cloth> {
    let square = square(n)?;
    let place = |p: &[f32; 3]| {
        let (s, c) = (p[0] * std::f32::consts::TAU).sin_cos();
        let round = if p[0] == 1.0 { [0.16, p[2], 0.0] } else { [0.16 * c, p[2], 0.16 * s] };
        if seam { round } else { *p }
    };
    let particle = |k: u32| {
        let next = match k % n {
            0 if seam => Some(k + n - 1),
            i if seam && i == n - 1 => Some(k - i),
            _ => None,
        };
        let held = k == 0 || k == n - 1;
        if held { Particle::Pinned { next } } else { Particle::Free { next } }
    };
    Cloth::new(Parts {
        name: "square".into(),
        grids: vec![Grid { name: "square".into(), first: 0, width: n, height: n }],
        positions: square.positions().iter().map(place).collect(),
        particles: (0..n * n).map(particle).collect(),
        rest,
        mass: Mass::Constant(square.mass(0)),
    })
}
