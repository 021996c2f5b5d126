//! A character file, dressed, and the joints of its animation over time.

use std::path::Path;

use gimage::colliders::{ColliderOptions, Tier};
use gimage::import::{Character, ImportOptions, inverse};
use gimage::options::{BuildOptions, ImageSize};
use gimage::pipeline::dress;
use gimage::progress::Quiet;
use gimage_bundle::dir::read_dir;
use gimage_bundle::{Body, Bundle, RENDER_FILE};
use gimage_runtime::{BodyCollider, Cloth, Skin};

use crate::{Collider, Error};

/// The motion of files without an animation.
pub const SWAY: &str = "sway";
/// Seconds in which a character goes from the pose in which its skins are bound into the animation, and the share of them in which it gets there.
pub const LEAD_S: f64 = 1.0;
const GETS_IN: f64 = 0.7;
/// How far each joint sways \[rad\], and how often \[1/s\].
const SWAY_RAD: f64 = 0.15;
const SWAY_HZ: f64 = 0.5;

type Matrix = [f64; 16];

/// A dressed character that moves.
pub struct Model {
    pub name: String,
    pub animation: String,
    pub collider: &'static str,
    pub cloth: Cloth,
    pub colliders: Vec<BodyCollider>,
    /// The mesh that depths are measured in.
    pub body: Body,
    skin: Skin,
    motion: Motion,
}

/// The source of the motion of the joints.
enum Motion {
    /// An animation, and the nodes of the joints.
    Played(Box<Character>, Vec<usize>),
    /// Each joint in the space of its parent, its parent, and whether that comes before it.
    Sway(Vec<(Matrix, Option<usize>)>),
}

impl Model {
    /// Dresses the character of a file, or takes a bundle that has the surface of its body.
    pub fn new(file: &Path, animation: &str, cloth: &[String], texels: u32, collider: Collider) -> Result<Self, Error> {
        let (mut bundle, body) = if file.is_dir() {
            let bundle = read_dir(file)?;
            let body = bundle.body.clone();
            (bundle, body)
        } else {
            dressed(file, cloth, texels, collider)?
        };
        let body = body.ok_or("the bundle has no surface of a body: dress the character with `--collider surface`")?;
        if collider == Collider::Capsules {
            bundle.body = None;
        }
        let cloth = Cloth::from_bundle("clothes", &bundle)?;
        let skin = cloth.skin().ok_or("the file has no joints")?.clone();
        let motion = if animation == SWAY {
            Motion::Sway(locals(&skin)?)
        } else {
            let inner = file.join(RENDER_FILE);
            let source = if file.is_dir() { &inner } else { file };
            let character = Character::read(source, animation, &ImportOptions::default())?;
            let nodes = skin.joints().iter().map(|j| character.node(&j.name)).collect::<Result<_, _>>()?;
            Motion::Played(Box::new(character), nodes)
        };
        let name = |part: Option<&std::ffi::OsStr>| part.map(|name| name.to_string_lossy().into_owned());
        let stem = name(file.file_stem()).unwrap_or_default();
        let folder = name(file.parent().and_then(Path::file_name)).unwrap_or_default();
        Ok(Model {
            name: if stem == "scene" { folder } else { stem },
            animation: animation.into(),
            collider: if bundle.body.is_some() { "surface" } else { "capsules" },
            colliders: BodyCollider::of_bundle(&bundle),
            cloth,
            body,
            skin,
            motion,
        })
    }

    /// Joint matrices at a time \[s\]: until -[`LEAD_S`] those of the pose in which the skins are bound, from 0 on those of the animation.
    pub fn joints(&self, time: f64) -> Result<Vec<[f32; 16]>, Error> {
        let t = ((time + LEAD_S) / (GETS_IN * LEAD_S)).clamp(0.0, 1.0);
        let share = t * t * (3.0 - 2.0 * t);
        let worlds: Vec<Matrix> = match &self.motion {
            Motion::Played(character, nodes) => {
                let worlds = character.worlds_between(time, share);
                nodes.iter().map(|n| worlds[*n]).collect()
            }
            Motion::Sway(joints) => sway(joints, time, share),
        };
        Ok(self.skin.matrices(&worlds.iter().map(|m| m.map(|x| x as f32)).collect::<Vec<_>>())?)
    }
}

/// The bundle of a character, and its body.
fn dressed(file: &Path, cloth: &[String], texels: u32, collider: Collider) -> Result<(Bundle, Option<Body>), Error> {
    let mut options = BuildOptions::default();
    options.image.size = ImageSize::Texels(texels);
    options.select.cloth = cloth.iter().map(|name| name.parse()).collect::<Result<_, _>>()?;
    let tier = if collider == Collider::Auto { Tier::Auto } else { Tier::Surface };
    let dress = |tier| dress(file, &options, &ColliderOptions { tier, ..ColliderOptions::default() }, &Quiet);
    let bundle = dress(tier)?.bundle;
    let body = match &bundle.body {
        Some(body) => Some(body.clone()),
        None => dress(Tier::Surface)?.bundle.body,
    };
    Ok((bundle, body))
}

/// Where each joint is bound, in the space of its parent.
fn locals(skin: &Skin) -> Result<Vec<(Matrix, Option<usize>)>, Error> {
    let of = |m: &[f32; 16]| m.map(f64::from);
    let local = |joint: &gimage_runtime::SkinJoint| -> Result<_, Error> {
        let bind = inverse(&of(&joint.inverse_bind)).ok_or("a joint is bound by a matrix without an inverse")?;
        let parent = joint.parent.map(|p| p as usize);
        Ok((parent.map_or(bind, |p| times(&of(&skin.joints()[p].inverse_bind), &bind)), parent))
    };
    skin.joints().iter().map(local).collect()
}

/// The transforms of joints to world space; each turns to and fro about an axis and with a phase of its own.
fn sway(joints: &[(Matrix, Option<usize>)], time: f64, share: f64) -> Vec<Matrix> {
    let own: Vec<Matrix> = joints
        .iter()
        .enumerate()
        .map(|(k, (local, _))| {
            let k = k as f64;
            let axis = [(1.3 * k).sin(), (2.1 * k + 1.0).sin(), (3.7 * k + 2.0).sin()];
            let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
            let angle = share * SWAY_RAD * (std::f64::consts::TAU * SWAY_HZ * time + k).sin();
            times(local, &rotation(axis.map(|x| x / length), angle))
        })
        .collect();
    let world = |k: usize| {
        let (mut at, mut matrix) = (k, own[k]);
        // A cycle of parents would end nowhere.
        for _ in 0..joints.len() {
            let Some(parent) = joints[at].1 else { break };
            (at, matrix) = (parent, times(&own[parent], &matrix));
        }
        matrix
    };
    (0..joints.len()).map(world).collect()
}

fn rotation([x, y, z]: [f64; 3], angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    let t = 1.0 - c;
    let [x1, x2, x3] = [t * x * x + c, t * x * y + s * z, t * x * z - s * y];
    let [y1, y2, y3] = [t * x * y - s * z, t * y * y + c, t * y * z + s * x];
    let [z1, z2, z3] = [t * x * z + s * y, t * y * z - s * x, t * z * z + c];
    [x1, x2, x3, 0.0, y1, y2, y3, 0.0, z1, z2, z3, 0.0, 0.0, 0.0, 0.0, 1.0]
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|n| (0..4).map(|k| a[4 * k + n % 4] * b[n / 4 * 4 + k]).sum())
}
