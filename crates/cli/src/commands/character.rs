//! A character whose animation moves cloths and colliders.

mod local;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use gimage::import::{Character, ImportOptions, Up};
use gimage::select::{Pattern, SelectOptions};
use gimage_bundle::{Manifest, RENDER_FILE};
use gimage_runtime::scene::Pose;
use gimage_runtime::scene::file::SceneFile;
use gimage_runtime::{Cloth, Scene, Solver, Stepper};

use crate::exit::Failure;
use crate::output::{Output, Tone};
use local::Local;

/// The animation of a scene: `gimage simulate`, `gimage render` and `gimage export`.
#[derive(Debug, Args)]
pub struct MotionArgs {
    /// Animation of the character file that moves the joints of the cloth (gimage list has the names); xpbd only.
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// The character: .glb or .gltf [default: that of the scene, or the file that the bundle was built
    /// from, beside the bundle, or render.glb in the bundle].
    #[arg(long, value_name = "FILE")]
    pub character: Option<PathBuf>,
    /// Seconds before time 0 in which the character goes from the pose in which its skins are bound into the animation, so that cloth starts as it was
    /// modelled and settles [default: 1 of a bundle, 0 of a scene file].
    #[arg(long, value_name = "SECONDS")]
    pub lead: Option<f64>,
    /// Simulates in the frame of reference of a joint (hips, root): pictures and dumps are in it too, so that the character stays in the middle.
    #[arg(long, value_name = "JOINT")]
    pub local: Option<String>,
    /// Shares of the motion of --local that cloth feels, from 0 to 1: one, or linear,angular,centrifugal [default: 1].
    #[arg(long, value_name = "SHARES", requires = "local")]
    pub inertia: Option<String>,
    /// How points that follow several joints move: the mean of the places where these put them (linear), or the mean of the motions, which keeps the
    /// volume of limbs that twist (dual-quaternion) [default: that of the scene, or linear].
    #[arg(long, value_enum, value_name = "HOW")]
    pub skinning: Option<SkinningArg>,
}

/// How points between joints move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SkinningArg {
    Linear,
    DualQuaternion,
}

/// Longest time before an animation \[s\], and how long that of a bundle is by default.
const LONGEST_LEAD_S: f64 = 60.0;
const LEAD_S: f64 = 1.0;
/// The share of that time in which the character gets into the animation; then the cloth settles.
const GETS_IN: f64 = 0.7;

/// A character, and those cloths and colliders of a scene that move with it.
pub struct Animated {
    /// Its file.
    pub path: PathBuf,
    /// How the bundle was read from it.
    pub reading: Reading,
    character: Character,
    /// Time before the animation \[s\].
    lead: f64,
    /// Indices of cloths, and the nodes of their joints.
    cloths: Vec<(usize, Vec<usize>)>,
    colliders: Vec<Attached>,
    /// The frame of reference, if it is not the world.
    local: Option<Local>,
}

/// A collider that a node moves.
struct Attached {
    index: usize,
    node: usize,
    /// Its pose where the transform of the node to world space is `from`.
    pose: Pose,
    from: [f64; 16],
}

/// How a bundle was read from the file of a character.
#[derive(Clone, Default)]
pub struct Reading {
    /// Where joints are.
    pub import: ImportOptions,
    /// Which parts became cloth.
    pub select: SelectOptions,
}

impl Reading {
    /// That of the options in a manifest.
    pub fn of(manifest: &Manifest) -> Self {
        let patterns = |name: &str| -> Vec<Pattern> {
            let list = manifest.options.get(name).and_then(|v| v.as_array());
            list.into_iter().flatten().filter_map(|v| v.as_str()?.parse().ok()).collect()
        };
        let select = SelectOptions { cloth: patterns("cloth"), body: patterns("body"), rigid: patterns("rigid") };
        Reading { import: import_options(manifest), select }
    }
}

fn import_options(manifest: &Manifest) -> ImportOptions {
    let option = |name: &str| manifest.options.get(name);
    let default = ImportOptions::default();
    ImportOptions {
        unit: option("unit").and_then(|v| v.as_f64()).unwrap_or(default.unit),
        up: option("up").and_then(|v| v.as_str()?.parse::<Up>().ok()).unwrap_or(default.up),
        center: option("center").and_then(|v| v.as_bool()).unwrap_or(default.center),
        ..default
    }
}

impl Animated {
    /// Reads an animation of a character, and has the cloths of a scene that have joints, and the colliders that the scene attaches to
    /// some, begin where it begins.
    pub fn new(
        (path, animation): (&Path, &str),
        reading: Reading,
        (lead, in_bundle): (f64, bool),
        frame: Option<(&str, Option<&str>)>,
        file: &mut SceneFile,
    ) -> Result<Self, Failure> {
        if !(0.0..=LONGEST_LEAD_S).contains(&lead) {
            return Err(Failure::refused(format!("--lead {lead}: give 0 to {LONGEST_LEAD_S} s")));
        }
        let character =
            Character::read(path, animation, &reading.import).map_err(|e| Failure::refused(e.to_string()))?;
        let node = |name: &str| character.node(name).map_err(|e| Failure::refused(e.to_string()));
        let rest = character.rest_worlds();
        let (mut cloths, mut colliders) = (Vec::new(), Vec::new());
        for (index, cloth) in file.scene.cloths.iter().enumerate() {
            let Some(skin) = cloth.skin() else { continue };
            cloths.push((index, skin.joints().iter().map(|j| node(&j.name)).collect::<Result<_, _>>()?));
        }
        for (index, joint) in file.joints.iter().enumerate() {
            let (Some(joint), Some(collider)) = (joint, file.scene.colliders.get(index)) else { continue };
            collider.check()?;
            let (node, pose) = (node(joint)?, collider.pose());
            let from = bound(&file.scene, joint).filter(|_| in_bundle).unwrap_or(rest[node]);
            colliders.push(Attached { index, node, pose, from });
        }
        if cloths.is_empty() && colliders.is_empty() {
            let hint = "build the bundle from a file with a skin, or from parts that its skeleton moves";
            return Err(Failure::refused(format!(
                "nothing of the scene follows the joints of {}; {hint}",
                path.display()
            )));
        }
        if !cloths.is_empty() && file.options.solver == Solver::Classic {
            return Err(Failure::refused("the solver `classic` moves no joints; use --solver xpbd"));
        }
        let moved: Vec<usize> = colliders.iter().map(|c: &Attached| c.index).collect();
        let local = frame.map(|of| Local::new(of, &character, &moved, &mut file.scene)).transpose()?;
        let animated = Animated { path: path.into(), reading, character, lead, cloths, colliders, local };
        animated.start(&mut file.scene)?;
        if !animated.character.loops() && animated.character.seconds() > 0.0 {
            file.scene.frames = (animated.character.seconds() / file.options.step).ceil() as u32;
        }
        Ok(animated)
    }

    /// Says what the animation leaves to be known.
    pub fn remark(&self, out: &Output) {
        let (name, seconds) = (self.character.name(), self.character.seconds());
        if !self.character.loops() && seconds > 0.0 {
            let text = format!("animation `{name}` does not end in its first pose: it plays once, for {seconds:.2} s");
            out.remark(Tone::Note, "note", &text);
        }
        if self.character.skipped() > 0 {
            let count = self.character.skipped();
            let text =
                format!("animation `{name}`: {count} channels move no node (morph targets); they are not played");
            out.remark(Tone::Note, "note", &text);
        }
    }

    fn start(&self, scene: &mut Scene) -> Result<(), Failure> {
        let worlds = self.worlds(-self.lead);
        for (index, nodes) in &self.cloths {
            let matrices = matrices(&scene.cloths[*index], nodes, &worlds)?;
            scene.cloths[*index].follow_joints(&matrices)?;
        }
        for attached in &self.colliders {
            let Pose { position, rotation } = attached.at(&worlds);
            let collider = &mut scene.colliders[attached.index];
            (collider.center, collider.rotation) = (position, rotation);
        }
        if let Some(local) = &self.local {
            for (index, Pose { position, rotation }) in local.fixed(&self.outside(-self.lead)) {
                let collider = &mut scene.colliders[index];
                (collider.center, collider.rotation) = (position, rotation);
            }
        }
        Ok(())
    }

    /// Time before the animation \[s\].
    pub fn lead(&self) -> f64 {
        self.lead
    }

    /// The character with its animation.
    pub fn character(&self) -> &Character {
        &self.character
    }

    /// The indices of the colliders that it moves.
    pub fn colliders(&self) -> impl Iterator<Item = usize> {
        self.colliders.iter().map(|attached| attached.index)
    }

    /// Where its nodes are at `time` \[s\], in the frame of reference; before 0 they are on their way into the animation.
    pub fn worlds(&self, time: f64) -> Vec<[f64; 16]> {
        let worlds = self.outside(time);
        match &self.local {
            Some(local) => local.inside(&worlds),
            None => worlds,
        }
    }

    /// The same in the world.
    fn outside(&self, time: f64) -> Vec<[f64; 16]> {
        if time >= 0.0 || self.lead <= 0.0 {
            return self.character.worlds(time.max(0.0));
        }
        let t = ((time + self.lead) / (GETS_IN * self.lead)).clamp(0.0, 1.0);
        self.character.worlds_between(time, t * t * (3.0 - 2.0 * t))
    }

    /// Moves everything to where it is at `time` \[s\], the end of the next frame.
    pub fn frame(&self, stepper: &mut Stepper, time: f64) -> Result<(), Failure> {
        let worlds = self.worlds(time);
        if let Some(local) = &self.local {
            let outside = self.outside(time);
            local.go(stepper, &outside, &self.outside(-self.lead))?;
            local.fixed(&outside).try_for_each(|(index, pose)| stepper.move_collider(index, &pose))?;
        }
        for (index, nodes) in &self.cloths {
            let matrices = matrices(&stepper.scene().cloths[*index], nodes, &worlds)?;
            stepper.set_joints(*index, &matrices)?;
        }
        for attached in &self.colliders {
            let pose = attached.at(&worlds);
            if stepper.scene().colliders[attached.index].pose() != pose {
                stepper.move_collider(attached.index, &pose)?;
            }
        }
        Ok(())
    }
}

/// The transform of a joint to world space where the cloths of a scene are bound to it.
fn bound(scene: &Scene, joint: &str) -> Option<[f64; 16]> {
    let of = |cloth: &Cloth| cloth.skin()?.joints().iter().find(|j| j.name == joint).map(|j| j.inverse_bind);
    gimage::import::inverse(&scene.cloths.iter().find_map(of)?.map(f64::from))
}

/// The joint matrices of a cloth.
fn matrices(cloth: &Cloth, nodes: &[usize], worlds: &[[f64; 16]]) -> Result<Vec<[f32; 16]>, Failure> {
    let own: Vec<[f32; 16]> = nodes.iter().map(|n| worlds[*n].map(|x| x as f32)).collect();
    Ok(cloth.skin().map_or(Ok(Vec::new()), |skin| skin.matrices(&own))?)
}

impl Attached {
    /// Its pose as the node goes to where it is now. Scales of the node do not scale it.
    fn at(&self, now: &[[f64; 16]]) -> Pose {
        let (from, to) = (Frame::of(&self.from), Frame::of(&now[self.node]));
        let own = Frame::turned(self.pose.rotation.map(f64::from));
        let p = self.pose.position.map(f64::from);
        // Into the frame of the node, and out of it where that is now.
        let local = from.axes.map(|axis| (0..3).map(|c| axis[c] * (p[c] - from.origin[c])).sum::<f64>());
        let out = |v: [f64; 3]| [0, 1, 2].map(|c| (0..3).map(|k| to.axes[k][c] * v[k]).sum::<f64>());
        let position = out(local);
        let inside = |v: [f64; 3]| from.axes.map(|axis| (0..3).map(|c| axis[c] * v[c]).sum::<f64>());
        let axes = own.axes.map(|axis| out(inside(axis)));
        Pose::of_axes([0, 1, 2].map(|c| (position[c] + to.origin[c]) as f32), &axes)
    }
}

/// A frame of three unit vectors and an origin.
struct Frame {
    axes: [[f64; 3]; 3],
    origin: [f64; 3],
}

impl Frame {
    /// That of a transform, without its scale and its shear.
    fn of(m: &[f64; 16]) -> Self {
        let column = |j: usize| [m[4 * j], m[4 * j + 1], m[4 * j + 2]];
        let x = unit(column(0));
        let y = column(1);
        let along: f64 = (0..3).map(|c| x[c] * y[c]).sum();
        let y = unit([0, 1, 2].map(|c| y[c] - along * x[c]));
        Frame { axes: [x, y, cross(x, y)], origin: column(3) }
    }

    /// That of a rotation about the origin.
    fn turned([x, y, z, w]: [f64; 4]) -> Self {
        let axes = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Frame { axes, origin: [0.0; 3] }
    }
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 0.0 { v.map(|x| x / norm) } else { [1.0, 0.0, 0.0] }
}

/// The time before an animation \[s\] that a scene has without `--lead`.
pub fn default_lead(scene: &Path) -> f64 {
    if scene.is_dir() { LEAD_S } else { 0.0 }
}

/// The character file of a bundle: the one given, else the file that the bundle was built from if it lies beside it, else the mesh in the
/// bundle, which has all of that file.
pub fn beside(bundle: &Path, given: Option<&Path>, source: &str) -> Result<PathBuf, Failure> {
    if let Some(path) = given {
        return Ok(path.into());
    }
    let path = bundle.parent().unwrap_or(Path::new("")).join(source);
    let within = bundle.join(RENDER_FILE);
    if (source.is_empty() || !path.is_file()) && within.is_file() {
        return Ok(within);
    }
    if source.is_empty() || !path.is_file() {
        let name = if source.is_empty() { "the file that the bundle was built from" } else { source };
        return Err(Failure::refused(format!(
            "{}: {name} is not beside the bundle, which has no render.glb; name it by --character FILE",
            bundle.display()
        )));
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STILL: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

    fn near(a: &[f32], b: &[f64]) -> bool {
        a.iter().zip(b).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6)
    }

    #[test]
    fn a_collider_goes_where_its_joint_goes() {
        // The joint is at (0, 1, 0) in the pose of the file; the collider 0.5 beside it, lying along x.
        let mut rest = STILL;
        rest[13] = 1.0;
        let h = 0.5f64.sqrt();
        let pose = Pose { position: [0.5, 1.0, 0.0], rotation: [0.0, 0.0, h as f32, h as f32] };
        let attached = Attached { index: 0, node: 0, pose, from: rest };
        let same = attached.at(&[rest]);
        assert!(near(&same.position, &[0.5, 1.0, 0.0]) && near(&same.rotation, &[0.0, 0.0, h, h]));
        // Turned by a quarter about y, at (2, 1, 0), three times as large: x goes to -z, and sizes stay.
        let turned = [0.0, 0.0, -3.0, 0.0, 0.0, 3.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 1.0, 0.0, 1.0];
        let moved = attached.at(&[turned]);
        assert!(near(&moved.position, &[2.0, 1.0, -0.5]), "{moved:?}");
        let y = moved.apply([0.0, 1.0, 0.0]);
        // The axis of a capsule, y, lay along -x.
        assert!(near(&y, &[2.0, 1.0, 0.5]), "{y:?}");
    }

    #[test]
    fn quaternions_are_those_of_their_axes() {
        for q in [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.5; 4]] {
            assert!(near(&Pose::of_axes([0.0; 3], &Frame::turned(q).axes).rotation, &q), "{q:?}");
        }
    }
}
