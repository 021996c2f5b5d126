//! From the fields of a file to a scene.

use super::error::{Error, Result};
use super::json::{self, From};
use super::{CharacterFile, Found, SceneFile, Source};
use crate::cloth::{Backstop, Cloth, ClothContact, Compliance, ContactTier, Flat, Select, Skinning};
use crate::collider::{Collider, Shape};
use crate::look::{Camera, Look, SolidLook, uv_of};
use crate::material::Material;
use crate::options::{Options, Solver};
use crate::quality::Quality;
use crate::scene::{Cut, Key, Motion, PinnedSet, Pose, Scene, Script, about};
use crate::wind::{Wind, WindForce};

/// Mass \[kg/m^2\] of flat cloth that says nothing about it.
const DENSITY: f64 = 0.2;

pub fn scene(file: json::File, find: &mut dyn FnMut(&Source) -> Found) -> Result<SceneFile> {
    let mut scene = Scene::new(&file.name);
    scene.gravity = file.gravity;
    scene.wind = file.wind.map(wind).transpose()?;
    let options = Options { thickness: file.thickness, ..options(&file.solver)? };
    options.check().map_err(Error::value("thickness"))?;
    let whole = |d: f64| (0.0..=86_400.0).contains(&d);
    crate::error::check("the duration [s]", file.duration, "0 to 86400", whole).map_err(Error::value("duration"))?;
    scene.frames = (file.duration / options.step).round() as u32;
    let mut script = Script::default();
    let (mut looks, mut sources) = (Vec::new(), Vec::new());
    for (index, fields) in file.cloths.into_iter().enumerate() {
        let place = format!("cloths[{index}]");
        let (cloth, look) = cloth(&fields, index, &place, find, &mut script)?;
        if file.character.is_some() && cloth.skin().is_some() {
            refuse_placed(&fields, &place)?;
        }
        cloth.check().map_err(Error::value(place))?;
        scene.cloths.push(cloth);
        looks.push(look);
        sources.push(source(&fields.from));
    }
    let mut joints = Vec::new();
    for (index, mut fields) in file.colliders.into_iter().enumerate() {
        let place = format!("colliders[{index}]");
        let joint = fields.joint.take();
        if joint.is_some() && (file.character.is_none() || !fields.motion.is_empty()) {
            let problem = "a collider moves with a joint of the scene's `character`, and has no `motion` then";
            return Err(Error::choice(format!("{place}.joint"), problem));
        }
        joints.push(joint);
        let (collider, motion) = collider(fields, &place)?;
        scene.colliders.push(collider);
        script.colliders.push(motion);
    }
    script.cuts = cuts(&file.cuts)?;
    scene.check().map_err(Error::value("gravity"))?;
    script.start(&mut scene);
    let camera = file.camera.map(|c| Camera { eye: c.eye, target: c.target, fov: c.fov_degrees.to_radians() });
    camera.iter().try_for_each(Camera::check).map_err(Error::value("camera"))?;
    let mut solid_look = SolidLook::default();
    solid_look.color = color("collider_color", file.collider_color)?.unwrap_or(solid_look.color);
    let background = color("background", file.background)?;
    let character = file.character.map(|json::Character { file, animation }| CharacterFile { file, animation });
    let clear_start = file.clear_start;
    Ok(SceneFile {
        scene,
        clear_start,
        script,
        options,
        camera,
        background,
        looks,
        solid_look,
        character,
        sources,
        joints,
    })
}

fn options(fields: &json::Solver) -> Result<Options> {
    let mut options = Options::default();
    options.solver = match fields.name.as_deref() {
        None => options.solver,
        Some("classic") => Solver::Classic,
        Some("xpbd") => Solver::Xpbd,
        Some(other) => {
            return Err(Error::choice("solver.name", format!("there is no solver {other:?}, only classic and xpbd")));
        }
    };
    options.substeps = fields.substeps;
    options.quality = Quality::of(fields.error, fields.budget);
    options.pyramid = fields.pyramid.unwrap_or(options.pyramid);
    options.polish = fields.polish;
    options.tethers = fields.tethers.unwrap_or(options.tethers);
    options.iterations = fields.iterations.unwrap_or(options.iterations);
    options.check().map_err(Error::value("solver"))?;
    Ok(options)
}

fn wind(fields: json::Wind) -> Result<Wind> {
    let json::Wind { velocity, gust_degrees, gust_size, force } = fields;
    let force = match force {
        json::Force::Push { response } => WindForce::Push { response },
        json::Force::Triangles { density, drag, lift } => WindForce::Triangles { density, drag, lift },
    };
    let wind = Wind { velocity, gust: gust_degrees.to_radians(), gust_size, force };
    wind.check().map_err(Error::value("wind"))?;
    Ok(wind)
}

fn color(field: &str, value: Option<[f32; 3]>) -> Result<Option<[f32; 3]>> {
    for x in value.iter().flatten() {
        let range = |x: f64| (0.0..=1.0).contains(&x);
        crate::error::check("a colour", f64::from(*x), "0 to 1", range).map_err(Error::value(field))?;
    }
    Ok(value)
}

fn rotation(fields: &json::Rotation, place: &str) -> Result<[f32; 4]> {
    let no_axis = fields.axis == [0.0; 3] && fields.degrees != 0.0;
    if no_axis || !fields.degrees.is_finite() || fields.axis.iter().any(|x| !x.is_finite()) {
        return Err(Error::choice(format!("{place}.rotation"), "give an axis longer than 0, and finite degrees"));
    }
    Ok(about(fields.axis, fields.degrees.to_radians()))
}

fn cloth(
    fields: &json::Cloth,
    index: usize,
    place: &str,
    find: &mut dyn FnMut(&Source) -> Found,
    script: &mut Script,
) -> Result<(Cloth, Look)> {
    let mut look = Look::of(index);
    let name = if fields.name.is_empty() { format!("cloth {index}") } else { fields.name.clone() };
    let mut cloth = match (&fields.from, source(&fields.from)) {
        (From::Flat { width, height, origin, right, down }, _) => {
            let side = |v: &[f32; 3]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            let mass = (DENSITY * side(right) * side(down)) as f32;
            let flat = Flat { name, width: *width, height: *height, origin: *origin, right: *right, down: *down, mass };
            let cloth = flat.cloth().map_err(Error::value(format!("{place}.from")))?;
            look.uv = Some(flat_uv(*width, *height));
            cloth
        }
        (_, Some(source)) => {
            let problem = |e: Box<dyn std::error::Error + Send + Sync>| e.to_string();
            let bundle = find(&source).map_err(problem);
            let bundle = bundle.map_err(|problem| Error::Source { field: format!("{place}.from"), problem })?;
            look.uv = uv_of(&bundle);
            Cloth::from_bundle(&name, &bundle).map_err(Error::value(format!("{place}.from")))?
        }
        (_, None) => return Err(Error::choice(format!("{place}.from"), "name a bundle, a garment or a flat cloth")),
    };
    let pose = Pose { position: fields.position, rotation: rotation(&fields.rotation, place)? };
    if pose != Pose::default() {
        let placed = cloth.positions().iter().map(|p| pose.apply(*p)).collect();
        cloth.place(placed).map_err(Error::value(format!("{place}.position")))?;
        cloth.carry_body(|p| pose.apply(p)).map_err(Error::value(format!("{place}.position")))?;
    }
    if let Some(fields) = &fields.material {
        cloth.set_material(&material(fields, place)?).map_err(Error::value(format!("{place}.material")))?;
    }
    if let Some(mass) = fields.mass {
        cloth.set_total_mass(mass).map_err(Error::value(format!("{place}.mass")))?;
    }
    (cloth.damping, cloth.velocity) = (fields.damping.unwrap_or(cloth.damping), fields.velocity);
    (cloth.thickness, cloth.friction) =
        (fields.thickness.or(cloth.thickness), fields.friction.unwrap_or(cloth.friction));
    cloth.collision_groups = collision_groups(fields.collision_groups.as_deref(), place)?;
    cloth.contact = fields.contact.as_ref().map(|contact| {
        let (tier, of) = match contact {
            json::Contact::Particles(of) => (ContactTier::Particles, of),
            json::Contact::Safe(of) => (ContactTier::Safe, of),
        };
        let friction = of.friction.unwrap_or(ClothContact::default().friction);
        ClothContact { tier, distance: of.distance, friction, layer: of.layer.unwrap_or(0) }
    });
    cloth.compliance = fields.compliance.map_or(Compliance::None, Compliance::Constant);
    if let Some(json::Backstop { distance, radius }) = fields.backstop {
        if !(distance >= 0.0 && distance.is_finite() && radius > 0.0 && radius.is_finite()) {
            return Err(Error::choice(
                format!("{place}.backstop"),
                "give a distance of at least 0 and a radius above 0",
            ));
        }
        cloth.backstops = Some(vec![Backstop { distance, radius }; cloth.len()].into());
    }
    cloth.speed_limit = fields.speed_limit.unwrap_or(cloth.speed_limit);
    cloth.skinning = match fields.skinning {
        Some(json::Skinning::DualQuaternion) => Skinning::DualQuaternion,
        Some(json::Skinning::Linear) | None => Skinning::Linear,
    };
    for (p, pins) in fields.pins.iter().enumerate() {
        let place = format!("{place}.pins[{p}]");
        let set = pinned(pins, index, &place, &cloth)?;
        let held: Vec<u32> = set.particles.iter().map(|(k, _)| *k as u32).collect();
        cloth.pin(&held).map_err(Error::value(&place))?;
        if set.motion.is_some() || set.release.is_some() {
            script.pins.push(set);
        }
    }
    if let Some(front) = color(&format!("{place}.front"), fields.front)? {
        look = Look { uv: look.uv, ..Look::plain(front) };
    }
    look.back = color(&format!("{place}.back"), fields.back)?.unwrap_or(look.back);
    match fields.checker {
        Some([tiles, shade]) if tiles > 0.0 && tiles.is_finite() && (0.0..=1.0).contains(&shade) => {
            look.checker = [tiles, shade];
        }
        Some(_) => {
            let problem = "give tiles above 0 and a shade of 0 to 1";
            return Err(Error::choice(format!("{place}.checker"), problem));
        }
        // Without a pattern there is no need for a buffer.
        None => look.uv = None,
    }
    Ok((cloth, look))
}

/// The source that the host is asked for; nothing for a flat cloth.
fn source(from: &From) -> Option<Source> {
    match from {
        From::Flat { .. } => None,
        From::Bundle(path) => Some(Source::Bundle(path.clone())),
        From::Garment { file, texels } => Some(Source::Garment { file: file.clone(), texels: *texels }),
    }
}

/// Refuses to put cloth that follows a character elsewhere, whole or by its pins.
fn refuse_placed(fields: &json::Cloth, place: &str) -> Result<()> {
    let moved = fields.position != [0.0; 3] || fields.rotation.degrees != 0.0;
    if moved || fields.pins.iter().any(|pins| !pins.motion.is_empty()) {
        let problem =
            "the `character` of the scene places this cloth and its pins; leave out position, rotation and motion";
        return Err(Error::choice(place, problem));
    }
    Ok(())
}

/// A field that is not given is that of the fabric, or as in the default.
fn material(fields: &json::Material, place: &str) -> Result<Material> {
    let json::Material { fabric, warp, weft, shear, bend, density, damping, thickness, friction } = fields;
    let mut material = match fabric {
        None => Material::default(),
        Some(name) => Material::named(name).ok_or_else(|| {
            let names: Vec<_> = Material::names().collect();
            Error::choice(format!("{place}.material.fabric"), format!("give one of {}", names.join(", ")))
        })?,
    };
    material.thickness = thickness.or(material.thickness);
    let all = [
        (&mut material.warp, warp),
        (&mut material.weft, weft),
        (&mut material.shear, shear),
        (&mut material.bend, bend),
        (&mut material.density, density),
        (&mut material.damping, damping),
        (&mut material.friction, friction),
    ];
    all.into_iter().for_each(|(to, from)| *to = from.unwrap_or(*to));
    Ok(material)
}

fn flat_uv(width: u32, height: u32) -> Vec<[f32; 2]> {
    let side = |k: u32, n: u32| k as f32 / (n.max(2) - 1) as f32;
    (0..width * height).map(|k| [side(k % width, width), side(k / width, height)]).collect()
}

fn pinned(fields: &json::Pins, index: usize, place: &str, cloth: &Cloth) -> Result<PinnedSet> {
    let (rule, field) = select(&fields.select);
    let particles = cloth.select(&rule).map_err(Error::value(format!("{place}.select.{field}")))?;
    if particles.is_empty() {
        return Err(Error::choice(format!("{place}.select"), "no particle is selected; nothing would be pinned"));
    }
    let particles: Vec<_> = particles.into_iter().map(|k| (k as usize, cloth.positions()[k as usize])).collect();
    let middle = |c: usize| {
        let sum: f64 = particles.iter().map(|(_, p)| f64::from(p[c])).sum();
        (sum / particles.len() as f64) as f32
    };
    let pivot = fields.pivot.unwrap_or([0, 1, 2].map(middle));
    let key = |(k, key): (usize, &json::PinKey)| {
        let rotation = rotation(&key.rotation, &format!("{place}.motion[{k}]"))?;
        Ok(Key { time: key.time, pose: Pose { position: key.offset, rotation } })
    };
    let keys = fields.motion.iter().enumerate().map(key).collect::<Result<Vec<_>>>()?;
    let release = fields.release;
    if release.is_some_and(|r| !r.is_finite() || r < 0.0) {
        return Err(Error::choice(format!("{place}.release"), "give a time of at least 0 s"));
    }
    Ok(PinnedSet { cloth: index, particles, motion: motion(keys, place)?, pivot, release })
}

fn motion(keys: Vec<Key>, place: &str) -> Result<Option<Motion>> {
    if keys.is_empty() {
        return Ok(None);
    }
    Motion::new(keys).map(Some).map_err(Error::value(format!("{place}.motion")))
}

/// The rule, and the name of its field.
fn select(fields: &json::Select) -> (Select<'_>, &'static str) {
    match fields {
        json::Select::Pinned {} => (Select::Pinned, "pinned"),
        json::Select::Box { low, high } => (Select::Box { low: *low, high: *high }, "box"),
        json::Select::Sphere { center, radius } => (Select::Sphere { center: *center, radius: *radius }, "sphere"),
        json::Select::Texels { piece, from, to } => {
            (Select::Texels { piece: piece.as_deref(), from: *from, to: *to }, "texels")
        }
        json::Select::Loop { index } => (Select::Loop(*index), "loop"),
    }
}

fn collider(fields: json::Collider, place: &str) -> Result<(Collider, Option<Motion>)> {
    let shape = match fields.shape {
        json::Shape::HalfSpace {} => Shape::HalfSpace,
        json::Shape::Sphere { radius } => Shape::Sphere { radius },
        json::Shape::Capsule { half_height, radius } => Shape::Capsule { half_height, radius },
        json::Shape::TaperedCapsule { half_height, radii } => Shape::TaperedCapsule { half_height, radii },
        json::Shape::Box { half } => Shape::Box { half },
        json::Shape::Ellipsoid { radii, closest } => Shape::Ellipsoid { radii, closest },
    };
    let rotation_at = |r: &json::Rotation| rotation(r, place);
    let rotation = rotation_at(&fields.rotation)?;
    let collision_groups = collision_groups(fields.collision_groups.as_deref(), place)?;
    let at = Collider::new(shape, fields.position);
    let collider = Collider { rotation, friction: fields.friction, collision_groups, ..at };
    collider.check().map_err(Error::value(place))?;
    let key = |k: &json::ColliderKey| {
        Ok(Key { time: k.time, pose: Pose { position: k.position, rotation: rotation_at(&k.rotation)? } })
    };
    let keys = fields.motion.iter().map(key).collect::<Result<Vec<_>>>()?;
    Ok((collider, motion(keys, place)?))
}

/// The mask of some groups; all where none are given.
fn collision_groups(groups: Option<&[u32]>, place: &str) -> Result<u32> {
    let Some(groups) = groups else { return Ok(u32::MAX) };
    groups.iter().try_fold(0, |mask, group| {
        let within = |g: f64| g <= 31.0;
        crate::error::check("a collision group", f64::from(*group), "0 to 31", within)
            .map_err(Error::value(format!("{place}.collision_groups")))?;
        Ok(mask | 1 << group)
    })
}

fn cuts(fields: &[json::Cut]) -> Result<Vec<Cut>> {
    let cut = |(k, c): (usize, &json::Cut)| {
        let triangle = [c.eye, c.a, c.b];
        let finite = triangle.as_flattened().iter().all(|x| x.is_finite()) && c.time.is_finite() && c.time >= 0.0;
        let wrong = || Error::choice(format!("cuts[{k}]"), "give finite points, and a time of at least 0 s");
        finite.then_some(Cut { time: c.time, triangle }).ok_or_else(wrong)
    };
    fields.iter().enumerate().map(cut).collect()
}
