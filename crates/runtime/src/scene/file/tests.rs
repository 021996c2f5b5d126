use serde_json::{Value, json};

use super::*;
use crate::{Shape, Stepper};

fn nothing(_: &Source) -> Found {
    Err("no such bundle".into())
}

/// A scene with one of everything.
fn full() -> Value {
    json!({
        "format": "gimage-scene", "version": 1, "name": "all", "duration": 0.5, "gravity": [0, -1, 0],
        "wind": {"velocity": [1, 0, 0], "gust_degrees": 30, "gust_size": 0.5, "force": {"push": {"response": 1}}},
        "solver": {"name": "classic", "substeps": 2, "iterations": 3, "error": 0.02, "budget": 1.5},
        "thickness": 0.003, "clear_start": true,
        "cloths": [{
            "name": "flag", "from": {"flat": {"width": 5, "height": 4, "right": [1, 0, 0], "down": [0, 0, 1]}},
            "position": [0, 1, 0], "rotation": {"axis": [0, 1, 0], "degrees": 90}, "mass": 0.5, "damping": 1,
            "thickness": 0.002, "friction": 0.5, "collision_groups": [0, 3],
            "contact": {"particles": {"distance": 0.004, "friction": 0.2, "layer": -2}},
            "velocity": [0, 0, 1], "speed_limit": 50, "front": [1, 0, 0], "back": [0, 0, 1], "checker": [8, 0.1],
            "pins": [
                {"select": {"texels": {"from": [0, 0], "to": [4, 0]}},
                 "motion": [{"time": 0}, {"time": 0.1, "offset": [0, 0.1, 0]}], "release": 0.2},
                {"select": {"sphere": {"center": [0, 1, 0], "radius": 0.01}}},
                {"select": {"box": {"low": [-1, 0.9, -2], "high": [2, 1.1, 2]}}},
                {"select": {"pinned": {}}}
            ]
        }],
        "colliders": [
            {"shape": {"half_space": {}}, "position": [0, -1, 0], "friction": 0.3, "collision_groups": [31]},
            {"shape": {"sphere": {"radius": 0.2}},
             "motion": [{"time": 0, "position": [0, 0, 0]}, {"time": 1, "position": [1, 0, 0]}]},
            {"shape": {"capsule": {"half_height": 0.2, "radius": 0.1}}},
            {"shape": {"box": {"half": [1, 2, 3]}}, "rotation": {"axis": [0, 0, 2], "degrees": 45}},
            {"shape": {"ellipsoid": {"radii": [1, 2, 3], "closest": true}}}
        ],
        "cuts": [{"time": 0.3, "eye": [0, 3, 3], "a": [-2, 0, 0], "b": [2, 0, 0]}],
        "camera": {"eye": [0, 1, 3], "target": [0, 1, 0], "fov_degrees": 40},
        "background": [1, 1, 1], "collider_color": [0.5, 0.5, 0.5]
    })
}

fn parse(value: &Value) -> Result<SceneFile> {
    SceneFile::parse(value.to_string().as_bytes(), nothing)
}

#[test]
fn every_field_reaches_the_scene() {
    let file = parse(&full()).unwrap();
    let scene = &file.scene;
    assert_eq!((scene.frames, file.options.substeps, file.options.iterations), (30, Some(2), 3));
    assert_eq!((file.options.thickness, file.clear_start), (0.003, Some(true)));
    assert_eq!(file.options.quality, crate::Quality::ErrorWithin { stretch: 0.02, ms: 1.5 });
    assert_eq!((scene.colliders.len(), file.script.colliders.len(), file.script.cuts.len()), (5, 5, 1));
    assert_eq!(scene.colliders[4].shape, Shape::Ellipsoid { radii: [1.0, 2.0, 3.0], closest: true });
    let cloth = &scene.cloths[0];
    assert!((cloth.total_mass() - 0.5).abs() < 1e-6);
    assert_eq!((cloth.thickness, cloth.friction, cloth.collision_groups), (Some(0.002), 0.5, 9));
    assert_eq!(
        cloth.contact,
        Some(crate::ClothContact { distance: Some(0.004), friction: 0.2, layer: -2, ..Default::default() })
    );
    assert_eq!([0, 1].map(|c: usize| scene.colliders[c].collision_groups), [1 << 31, u32::MAX]);
    assert!((0..20).all(|k| cloth.inverse_mass(k) == 0.0), "the box selects all");
    // A quarter turn about +y takes x to -z.
    let last = cloth.positions()[4];
    assert!((last[0]).abs() < 1e-6 && (last[1] - 1.0).abs() < 1e-6 && (last[2] + 1.0).abs() < 1e-6, "{last:?}");
    assert_eq!((file.looks[0].checker, file.looks[0].uv.as_ref().map(Vec::len)), ([8.0, 0.1], Some(20)));
    let wind = scene.wind.unwrap();
    assert!((wind.gust - 30f32.to_radians()).abs() < 1e-6);
    assert!((file.camera.unwrap().fov - 40f32.to_radians()).abs() < 1e-6);
}

#[test]
fn a_material_sets_masses_and_damping() {
    let mut value = full();
    let fields = value["cloths"][0].as_object_mut().unwrap();
    fields.retain(|name, _| !["mass", "damping", "thickness", "friction"].contains(&name.as_str()));
    fields.insert("material".into(), json!({"warp": 800, "bend": 0, "density": 0.4, "damping": 3, "friction": 0.25}));
    let cloth = parse(&value).unwrap().scene.cloths.remove(0);
    assert!((cloth.total_mass() - 0.4).abs() < 1e-6 && cloth.damping == 3.0);
    assert!(cloth.bending().is_none());
    assert_eq!((cloth.thickness, cloth.friction), (None, 0.25));
    assert_eq!(cloth.membrane().unwrap().soft, [1.0 / 400.0, 1.0 / 800.0, 1.0 / 40.0]);
    // Fields beside the material override it.
    value["cloths"][0]["mass"] = json!(0.5);
    value["cloths"][0]["damping"] = json!(1);
    value["cloths"][0]["friction"] = json!(0.75);
    value["cloths"][0]["material"]["thickness"] = json!(0.004);
    let cloth = parse(&value).unwrap().scene.cloths.remove(0);
    assert!((cloth.total_mass() - 0.5).abs() < 1e-6 && cloth.damping == 1.0);
    assert_eq!((cloth.thickness, cloth.friction), (Some(0.004), 0.75));
    value["cloths"][0]["thickness"] = json!(0.002);
    assert_eq!(parse(&value).unwrap().scene.cloths[0].thickness, Some(0.002));
    value["cloths"][0]["material"]["shear"] = json!(-1);
    let error = parse(&value).unwrap_err().to_string();
    assert!(error.starts_with("cloths[0].material: the stiffness in shear"), "{error}");
    value["cloths"][0]["material"] = json!({"stiffness": 1});
    assert!(parse(&value).unwrap_err().to_string().contains("stiffness"));
}

#[test]
fn a_character_and_the_joints_of_colliders_are_the_hosts_to_play() {
    let mut value = full();
    value["character"] = json!({"file": "mage.glb", "animation": "run"});
    value["colliders"][2]["joint"] = json!("spine");
    let file = parse(&value).unwrap();
    assert_eq!(file.character, Some(CharacterFile { file: "mage.glb".into(), animation: "run".into() }));
    assert_eq!(file.joints, [None, None, Some("spine".to_string()), None, None]);
    value["colliders"][1]["joint"] = json!("spine");
    assert!(parse(&value).unwrap_err().to_string().starts_with("colliders[1].joint"));
    let mut alone = full();
    alone["colliders"][2]["joint"] = json!("spine");
    assert!(parse(&alone).unwrap_err().to_string().starts_with("colliders[2].joint"));
}

#[test]
fn the_script_moves_and_lets_go() {
    let mut value = full();
    value["cloths"][0]["pins"].as_array_mut().unwrap().truncate(1);
    let SceneFile { scene, script, options, .. } = parse(&value).unwrap();
    let mut stepper = Stepper::on_cpu(scene, options).unwrap();
    let dt = stepper.options().step;
    let start = stepper.positions(0).unwrap()[0];
    let mut run = |from: u32, to: u32| {
        for frame in from..to {
            script.frame(&mut stepper, f64::from(frame) * dt, dt).unwrap();
            stepper.advance(dt).unwrap();
        }
        (stepper.positions(0).unwrap()[0], stepper.scene().colliders[1])
    };
    let (at, sphere) = run(0, 9);
    assert!((at[1] - start[1] - 0.1).abs() < 1e-5 && at[3] == 0.0, "{at:?}");
    assert!((f64::from(sphere.center[0]) - 9.0 * dt).abs() < 1e-5 && (sphere.velocity[0] - 1.0).abs() < 1e-3);
    let (at, _) = run(9, 30);
    assert!(at[3] > 0.0 && (at[1] - start[1] - 0.1).abs() > 1e-3, "released: {at:?}");
    let (_, sphere) = run(30, 62);
    assert_eq!((sphere.center, sphere.velocity), ([1.0, 0.0, 0.0], [0.0; 3]));
}

#[test]
fn a_loop_is_pinned() {
    let mut value = full();
    value["cloths"][0]["pins"] = json!([{"select": {"loop": {"index": 0}}}]);
    let cloth = &parse(&value).unwrap().scene.cloths[0];
    // The border of 5 x 4 texels.
    assert_eq!((0..20).filter(|k| cloth.inverse_mass(*k) == 0.0).count(), 14);
}

#[test]
fn mistakes_are_told_with_their_field() {
    let at = |value: &mut Value, pointer: &str, new: Value| match value.pointer_mut(pointer) {
        Some(old) => *old = new,
        // A field that has a default.
        None => {
            let (parent, name) = pointer.rsplit_once('/').unwrap();
            value.pointer_mut(parent).unwrap()[name] = new;
        }
    };
    for (pointer, new, field) in [
        ("/cloths/0/pins/1/select/sphere/radius", json!("x"), "cloths[0].pins[1].select"),
        ("/cloths/0/pins/1/select/sphere/radius", json!(-1), "cloths[0].pins[1].select"),
        ("/cloths/0/pins/0/select/texels/to", json!([4]), "cloths[0].pins[0].select"),
        (
            "/cloths/0/pins/1/select",
            json!({"loop": {"index": 9}}),
            "cloths[0].pins[1].select.loop: there is no boundary loop 9",
        ),
        ("/cloths/0/pins/0/select/texels/piece", json!("arm"), "cloths[0].pins[0].select.texels: cloth"),
        ("/cloths/0/pins/0/release", json!(-1), "cloths[0].pins[0].release"),
        ("/cloths/0/pins/0/motion/1/time", json!(0), "cloths[0].pins[0].motion"),
        ("/cloths/0/from", json!({"bundle": "x.gim"}), "cloths[0].from: no such bundle"),
        ("/cloths/0/from", json!({"garment": {"file": "x.glb", "texels": 9}}), "cloths[0].from: no such bundle"),
        ("/cloths/0/from/flat/width", json!(1), "cloths[0].from"),
        ("/cloths/0/damping", json!(-1), "cloths[0]"),
        ("/cloths/0/mass", json!(0), "cloths[0].mass"),
        ("/cloths/0/thickness", json!(-0.001), "cloths[0]: the thickness"),
        ("/cloths/0/thickness", json!("thick"), "cloths[0].thickness"),
        ("/cloths/0/friction", json!(-1), "cloths[0]: the friction"),
        ("/cloths/0/collision_groups", json!([0, 32]), "cloths[0].collision_groups: a collision group is 32"),
        ("/cloths/0/collision_groups", json!(1), "cloths[0].collision_groups"),
        ("/cloths/0/front", json!([2, 0, 0]), "cloths[0].front"),
        ("/cloths/0/checker", json!([0, 0]), "cloths[0].checker"),
        ("/cloths/0/rotation/axis", json!([0, 0, 0]), "cloths[0].rotation"),
        ("/cloths/0", json!({}), "cloths[0]: missing field `from`"),
        ("/colliders/1/shape/sphere/radius", json!(0), "colliders[1]"),
        ("/colliders/1/shape", json!({"cone": {}}), "colliders[1].shape"),
        ("/colliders/1/motion/0/time", json!(-1), "colliders[1].motion"),
        ("/colliders/0/friction", json!(-1), "colliders[0]"),
        ("/colliders/0/collision_groups", json!([-1]), "colliders[0].collision_groups"),
        ("/wind/gust_degrees", json!(1000), "wind"),
        ("/wind/force", json!({"push": {"response": 1, "drag": 2}}), "wind.force"),
        ("/cloths/0/contact", json!("off"), "cloths[0].contact"),
        ("/cloths/0/contact/particles/distance", json!(0), "cloths[0]: the contact distance"),
        ("/cloths/0/contact/particles/layer", json!(0.5), "cloths[0].contact"),
        ("/solver/name", json!("best"), "solver.name"),
        ("/solver/substeps", json!(0), "solver"),
        ("/solver/error", json!(2), "solver"),
        ("/solver/budget", json!(0), "solver"),
        ("/thickness", json!(-0.001), "thickness"),
        ("/cuts/0/time", json!(-1), "cuts[0]"),
        ("/camera/eye", json!([0, 1, 0]), "camera"),
        ("/background", json!([0, 0]), "background"),
        ("/duration", json!(-1), "duration"),
        ("/version", json!(2), "version is 2, not 1"),
        ("/format", json!("other"), "format is \"other\""),
    ] {
        let mut value = full();
        at(&mut value, pointer, new);
        let error = parse(&value).unwrap_err().to_string();
        assert!(error.starts_with(field), "{pointer}: {error}");
    }
    for object in ["", "/wind", "/solver", "/cloths/0", "/cloths/0/pins/0", "/colliders/0", "/cuts/0", "/camera"] {
        let mut value = full();
        value.pointer_mut(object).unwrap()["unheard_of"] = json!(1);
        let error = parse(&value).unwrap_err().to_string();
        assert!(error.contains("unheard_of"), "{object}: {error}");
    }
    for text in ["", "[]", "{", "null", "{\"format\": 7}"] {
        assert!(SceneFile::parse(text.as_bytes(), nothing).is_err(), "{text}");
    }
}
