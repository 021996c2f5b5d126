//! A hand that an animation takes through clothes beneath which the body is guessed, from the file to the surface of the body.

use gimage::colliders::{ColliderOptions, Fit, fit_colliders};
use gimage::options::BuildOptions;
use gimage_tests::asset;
use gimage_tests::glb::Glb;
use serde_json::Value;

/// Joints of the figure beneath its skirt.
const BENEATH: [&str; 4] = ["hips", "spine", "thigh.L", "thigh.R"];
/// The left shoulder turned about z, in halves of angles: the hand, which is aside of the hip at rest, is in the thigh.
const TURN: f32 = -0.5 * 0.80;

/// The figure, to be changed.
struct File(Glb);

impl File {
    fn node(&self, name: &str) -> usize {
        self.0.json["nodes"].as_array().unwrap().iter().position(|n| n["name"] == name).unwrap()
    }

    /// Where an accessor begins, and how many elements it has.
    fn place(&self, accessor: usize) -> (usize, usize) {
        let accessor = &self.0.json["accessors"][accessor];
        let view = &self.0.json["bufferViews"][number(&accessor["bufferView"])];
        (number(&view["byteOffset"]) + number(&accessor["byteOffset"]), number(&accessor["count"]))
    }

    /// Takes the triangles out of the body whose first corner follows one of these joints most.
    fn take_out(&mut self, names: &[&str]) {
        let skin = &self.0.json["skins"][0]["joints"];
        let taken: Vec<bool> = (skin.as_array().unwrap().iter())
            .map(|node| names.iter().any(|name| self.node(name) == number(node)))
            .collect();
        let primitive = &self.0.json["meshes"][0]["primitives"][0];
        assert_eq!(self.0.json["meshes"][0]["name"], "Body");
        let of = |name: &str| self.place(number(&primitive["attributes"][name])).0;
        let (joints, weights) = (of("JOINTS_0"), of("WEIGHTS_0"));
        let index = number(&primitive["indices"]);
        let (at, count) = self.place(index);
        let corner =
            |n: usize| usize::from(u16::from_le_bytes([self.0.bytes[at + 2 * n], self.0.bytes[at + 2 * n + 1]]));
        let strongest = |v: usize| (0..4).max_by_key(|k| self.0.bytes[weights + 4 * v + k]).unwrap();
        let goes = |v: usize| taken[usize::from(self.0.bytes[joints + 4 * v + strongest(v)])];
        let stay: Vec<u8> = (0..count / 3)
            .filter(|t| !goes(corner(3 * t)))
            .flat_map(|t| self.0.bytes[at + 6 * t..at + 6 * t + 6].to_vec())
            .collect();
        assert!((1000..3 * count / 2).contains(&stay.len()), "{} of {count}", stay.len());
        self.0.json["accessors"][index]["count"] = (stay.len() / 2).into();
        self.0.bytes[at..at + stay.len()].copy_from_slice(&stay);
    }

    /// Turns a joint about z, for as long as an animation lasts, by an angle twice as large as `half` \[rad\].
    fn turn(&mut self, animation: &str, joint: &str, half: f32) {
        let node = self.node(joint);
        let all = self.0.json["animations"].as_array().unwrap();
        let animation = all.iter().find(|a| a["name"] == animation).unwrap();
        let turns = |c: &&Value| number(&c["target"]["node"]) == node && c["target"]["path"] == "rotation";
        let channel = animation["channels"].as_array().unwrap().iter().find(turns).unwrap();
        let (at, count) = self.place(number(&animation["samplers"][number(&channel["sampler"])]["output"]));
        let (sin, cos) = half.sin_cos();
        let turned: Vec<u8> = [0.0, 0.0, sin, cos].into_iter().flat_map(f32::to_le_bytes).collect();
        (0..count).for_each(|n| self.0.bytes[at + 16 * n..at + 16 * n + 16].copy_from_slice(&turned));
    }
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

/// The colliders of the figure after a change.
fn fitted(change: impl Fn(&mut File)) -> Fit {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("figure.glb");
    let mut file = File(Glb::read(&asset("figure.glb")));
    change(&mut file);
    file.0.write(&path);
    fit_colliders(&path, &BuildOptions::default(), &ColliderOptions::default()).unwrap()
}

/// Triangles of the surface of the body with a corner near the left hand at rest, and near the right one.
fn at_hands(fit: &Fit) -> [usize; 2] {
    let body = &fit.surface.as_ref().unwrap().body;
    let near = |x: f32, p: &[f32; 3]| (p[0] - x).hypot(p[1] - 0.96).hypot(p[2]) < 0.08;
    [0.51, -0.51]
        .map(|x| body.triangles.iter().filter(|t| t.iter().any(|v| near(x, &body.positions[*v as usize]))).count())
}

#[test]
fn a_hand_that_passes_through_the_skirt_above_a_guessed_thigh_is_not_in_the_surface() {
    let passing = |fit: &Fit| fit.findings.iter().find(|f| f.kind == "hint-passing").cloned();
    let plain = fitted(|file| file.take_out(&BENEATH));
    assert!(plain.colliders.iter().any(|c| c.guessed), "no solid is guessed");
    assert_eq!(passing(&plain), None);
    let [left, right] = at_hands(&plain);
    assert!(left > 50 && right > 50, "{left} {right}");
    let turned = fitted(|file| {
        file.take_out(&BENEATH);
        file.turn("Walk", "upper_arm.L", TURN);
    });
    let found = passing(&turned).expect("a note of the hand");
    assert!(found.message.contains("hand.L") && !found.message.contains(".R"), "{}", found.message);
    assert_eq!(at_hands(&turned), [0, right]);
    let of = |fit: &Fit| fit.surface.as_ref().unwrap().body.triangles.len() as u64;
    // The opening that the hand leaves is closed.
    assert!((1..100).contains(&(of(&turned) + found.count - of(&plain))), "{} of {}", of(&turned), of(&plain));
    // A whole body has a place for the hand: its own surface.
    let whole = fitted(|file| file.turn("Walk", "upper_arm.L", TURN));
    assert_eq!((passing(&whole), at_hands(&whole)), (None, [left, right]));
}
