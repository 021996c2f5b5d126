//! A character whose animation moves cloths and colliders.

use std::path::{Path, PathBuf};

use clap::Args;
use gimage::import::{Character, ImportOptions, Up};
use gimage_bundle::Manifest;
use gimage_runtime::scene::Pose;
use gimage_runtime::scene::file::SceneFile;
use gimage_runtime::{Cloth, Scene, Solver, Stepper};

use crate::exit::Failure;
use crate::output::{Output, Tone};

/// The animation of a scene: `gimage simulate`, `gimage render` and `gimage export`.
#[derive(Debug, Args)]
pub struct MotionArgs {
    /// Animation of the character file that moves the joints of the cloth (gimage list has the names); xpbd only.
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// The character: .glb or .gltf [default: that of the scene, or the file that the bundle was built from, beside the bundle].
    #[arg(long, value_name = "FILE")]
    pub character: Option<PathBuf>,
}

/// A character, and those cloths and colliders of a scene that move with it.
pub struct Animated {
    character: Character,
    /// Indices of cloths, and the nodes of their joints.
    cloths: Vec<(usize, Vec<usize>)>,
    colliders: Vec<Attached>,
}

/// A collider that a node moves.
struct Attached {
    index: usize,
    node: usize,
    /// Its pose where the node is in the pose of the file.
    pose: Pose,
}

/// The options of the import that made a bundle, as far as they say where joints are.
pub fn import_options(manifest: &Manifest) -> ImportOptions {
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
        options: &ImportOptions,
        file: &mut SceneFile,
    ) -> Result<Self, Failure> {
        let character = Character::read(path, animation, options).map_err(|e| Failure::refused(e.to_string()))?;
        let node = |name: &str| character.node(name).map_err(|e| Failure::refused(e.to_string()));
        let (mut cloths, mut colliders) = (Vec::new(), Vec::new());
        for (index, cloth) in file.scene.cloths.iter().enumerate() {
            let Some(skin) = cloth.skin() else { continue };
            cloths.push((index, skin.joints().iter().map(|j| node(&j.name)).collect::<Result<_, _>>()?));
        }
        for (index, joint) in file.joints.iter().enumerate() {
            let (Some(joint), Some(collider)) = (joint, file.scene.colliders.get(index)) else { continue };
            collider.check()?;
            colliders.push(Attached { index, node: node(joint)?, pose: collider.pose() });
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
        let animated = Animated { character, cloths, colliders };
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
        let worlds = self.character.worlds(0.0);
        for (index, nodes) in &self.cloths {
            let matrices = matrices(&scene.cloths[*index], nodes, &worlds)?;
            scene.cloths[*index].follow_joints(&matrices)?;
        }
        let rest = self.character.rest_worlds();
        for attached in &self.colliders {
            let Pose { position, rotation } = attached.at(&rest, &worlds);
            let collider = &mut scene.colliders[attached.index];
            (collider.center, collider.rotation) = (position, rotation);
        }
        Ok(())
    }

    /// Moves everything to where it is at `time` \[s\], the end of the next frame.
    pub fn frame(&self, stepper: &mut Stepper, time: f64) -> Result<(), Failure> {
        let worlds = self.character.worlds(time);
        for (index, nodes) in &self.cloths {
            let matrices = matrices(&stepper.scene().cloths[*index], nodes, &worlds)?;
            stepper.set_joints(*index, &matrices)?;
        }
        let rest = if self.colliders.is_empty() { Vec::new() } else { self.character.rest_worlds() };
        for attached in &self.colliders {
            let pose = attached.at(&rest, &worlds);
            if stepper.scene().colliders[attached.index].pose() != pose {
                stepper.move_collider(attached.index, &pose)?;
            }
        }
        Ok(())
    }
}

/// The joint matrices of a cloth.
fn matrices(cloth: &Cloth, nodes: &[usize], worlds: &[[f64; 16]]) -> Result<Vec<[f32; 16]>, Failure> {
    let own: Vec<[f32; 16]> = nodes.iter().map(|n| worlds[*n].map(|x| x as f32)).collect();
    Ok(cloth.skin().map_or(Ok(Vec::new()), |skin| skin.matrices(&own))?)
}

impl Attached {
    /// Its pose as the node goes from the pose of the file to another one. Scales of the node do not scale it.
    fn at(&self, rest: &[[f64; 16]], now: &[[f64; 16]]) -> Pose {
        let (from, to) = (Frame::of(&rest[self.node]), Frame::of(&now[self.node]));
        let own = Frame::turned(self.pose.rotation.map(f64::from));
        let p = self.pose.position.map(f64::from);
        // Into the frame of the node, and out of it where that is now.
        let local = from.axes.map(|axis| (0..3).map(|c| axis[c] * (p[c] - from.origin[c])).sum::<f64>());
        let out = |v: [f64; 3]| [0, 1, 2].map(|c| (0..3).map(|k| to.axes[k][c] * v[k]).sum::<f64>());
        let position = out(local);
        let inside = |v: [f64; 3]| from.axes.map(|axis| (0..3).map(|c| axis[c] * v[c]).sum::<f64>());
        let axes = own.axes.map(|axis| out(inside(axis)));
        Pose { position: [0, 1, 2].map(|c| (position[c] + to.origin[c]) as f32), rotation: quaternion(&axes) }
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

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 0.0 { v.map(|x| x / norm) } else { [1.0, 0.0, 0.0] }
}

/// The unit quaternion of three axes, from the largest of its components (S. W. Shepperd, 1978).
fn quaternion([a, b, c]: &[[f64; 3]; 3]) -> [f32; 4] {
    let squares =
        [1.0 + a[0] - b[1] - c[2], 1.0 - a[0] + b[1] - c[2], 1.0 - a[0] - b[1] + c[2], 1.0 + a[0] + b[1] + c[2]];
    let largest = (0..4).max_by(|i, j| squares[*i].total_cmp(&squares[*j])).unwrap_or(3);
    let s = 2.0 * squares[largest].max(1e-12).sqrt();
    let q = match largest {
        0 => [s / 4.0, (a[1] + b[0]) / s, (a[2] + c[0]) / s, (b[2] - c[1]) / s],
        1 => [(a[1] + b[0]) / s, s / 4.0, (b[2] + c[1]) / s, (c[0] - a[2]) / s],
        2 => [(a[2] + c[0]) / s, (b[2] + c[1]) / s, s / 4.0, (a[1] - b[0]) / s],
        _ => [(b[2] - c[1]) / s, (c[0] - a[2]) / s, (a[1] - b[0]) / s, s / 4.0],
    };
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| (x / norm) as f32)
}

/// The character file of a bundle: the one given, else the file that the bundle was built from if it lies beside it.
pub fn beside(bundle: &Path, given: Option<&Path>, source: &str) -> Result<PathBuf, Failure> {
    if let Some(path) = given {
        return Ok(path.into());
    }
    let path = bundle.parent().unwrap_or(Path::new("")).join(source);
    if source.is_empty() || !path.is_file() {
        let name = if source.is_empty() { "the file that the bundle was built from" } else { source };
        return Err(Failure::refused(format!(
            "{}: {name} is not beside the bundle; name it by --character FILE",
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
        let attached = Attached { index: 0, node: 0, pose };
        let same = attached.at(&[rest], &[rest]);
        assert!(near(&same.position, &[0.5, 1.0, 0.0]) && near(&same.rotation, &[0.0, 0.0, h, h]));
        // Turned by a quarter about y, at (2, 1, 0), three times as large: x goes to -z, and sizes stay.
        let turned = [0.0, 0.0, -3.0, 0.0, 0.0, 3.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 1.0, 0.0, 1.0];
        let moved = attached.at(&[rest], &[turned]);
        assert!(near(&moved.position, &[2.0, 1.0, -0.5]), "{moved:?}");
        let y = moved.apply([0.0, 1.0, 0.0]);
        // The axis of a capsule, y, lay along -x.
        assert!(near(&y, &[2.0, 1.0, 0.5]), "{y:?}");
    }

    #[test]
    fn quaternions_are_those_of_their_axes() {
        for q in [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.5; 4]] {
            assert!(near(&quaternion(&Frame::turned(q).axes), &q), "{q:?}");
        }
    }
}
