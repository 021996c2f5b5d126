//! A character file and one of its animations: where its nodes are over time.

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use serde_json::Value;

use super::accessor::Accessors;
use super::animation::{Channel, Clip, Target};
use super::bound::bound;
use super::buffers::Buffers;
use super::document::Document;
use super::local::Local;
use super::matrix::{self, Matrix};
use super::nodes::Forest;
use super::place::axes;
use super::scene::Animation;
use super::source::Source;
use super::{EXPORT_AGAIN, ImportOptions, glb, malformed, sniff, source};
use crate::error::{Error, Result};

/// How far \[m\] or, of directions, as a share of 1, the last pose of an animation may be from its first one if it loops.
const SAME_POSE: f64 = 0.01;

/// The nodes of a glTF file, and one of its animations.
#[derive(Clone, Debug)]
pub struct Character {
    file: String,
    names: Vec<String>,
    /// Whether each is a joint of a skin.
    is_joint: Vec<bool>,
    parents: Vec<Option<usize>>,
    /// Parents before their children.
    order: Vec<usize>,
    rest: Vec<Local>,
    /// The pose in which skins are bound.
    start: Vec<Local>,
    clip: Clip,
    name: String,
    loops: bool,
    unit: f64,
    /// Turns the up axis of the file to y.
    turn: Matrix,
}

impl Character {
    /// Reads a `.glb` or `.gltf` file and the animation of this name. `options` are those of the import that made the bundle: unit and axis.
    /// Errors if the file has no such animation, on damaged key frames, and on `center`, which moves a garment by its box.
    pub fn read(path: &Path, animation: &str, options: &ImportOptions) -> Result<Self> {
        options.check()?;
        let mut found = None;
        Character::guarded(path, Some(animation), options, &mut |one| found = Some(one))?;
        found.unwrap_or_else(|| Err(no_animation(path, animation, &[])))
    }

    /// Calls `with` for all animations of a file that can be read, in its order, one at a time in memory; for none of a file without nodes, or
    /// with `center`.
    pub(crate) fn each(path: &Path, options: &ImportOptions, mut with: impl FnMut(Self)) {
        _ = Character::guarded(path, None, options, &mut |one| _ = one.map(&mut with));
    }

    /// As for an import: should a decoder panic on a damaged file, its caller gets an error.
    fn guarded(
        path: &Path,
        animation: Option<&str>,
        options: &ImportOptions,
        with: &mut dyn FnMut(Result<Self>),
    ) -> Result<()> {
        catch_unwind(AssertUnwindSafe(|| Character::open(path, animation, options, with))).unwrap_or_else(|_| {
            Err(malformed(path, "file", "it is damaged in a way that stopped the reader", EXPORT_AGAIN))
        })
    }

    /// One animation of a file, or each of them.
    fn open(
        path: &Path,
        animation: Option<&str>,
        options: &ImportOptions,
        with: &mut dyn FnMut(Result<Self>),
    ) -> Result<()> {
        if options.center {
            return Err(Error::Option {
                option: "center".into(),
                problem: "an animation moves the character where the file has it".into(),
                hint: "build the bundle without --center".into(),
            });
        }
        let bytes = source::read_capped(path, options.max_bytes)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let resolver = |name: &str| source::read_beside(&folder, name, options.max_bytes);
        let mut source = Source::new(path, &bytes);
        let (json, bin) = match sniff::sniff(path, &bytes)? {
            sniff::Format::Glb => {
                let chunks = glb::split(path, &bytes)?;
                (chunks.json, chunks.bin)
            }
            sniff::Format::Gltf => (&bytes[..], None),
            sniff::Format::Obj => return Err(no_animation(path, animation.unwrap_or_default(), &[])),
        };
        let doc = Document::parse(path, json, &mut source)?;
        let buffers = Buffers::new(&doc, bin, &resolver, options.max_bytes);
        let accessors = Accessors { doc: &doc, buffers: &buffers, max_count: options.max_vertices };
        let chosen: Vec<usize> = match animation {
            Some(name) => {
                let found = doc.animations.iter().position(|a| a.name == name);
                vec![found.ok_or_else(|| no_animation(path, name, &doc.animations))?]
            }
            None => (0..doc.animations.len()).collect(),
        };
        let forest = Forest::new(&doc)?;
        let rest = Local::all(&doc);
        let placed = |c: &Channel| matches!(rest[c.node], Local::Matrix(_));
        let start = bound(&accessors, &forest, &rest);
        let names: Vec<String> = (0..rest.len()).map(|n| doc.node_name(n)).collect();
        let joints: HashSet<usize> = doc.root.skins.iter().flat_map(|s| &s.joints).map(|j| j.value()).collect();
        let is_joint: Vec<bool> = (0..rest.len()).map(|n| joints.contains(&n)).collect();
        let one = |index: usize| {
            let clip = Clip::read(&accessors, index)?;
            if let Some(c) = clip.channels.iter().find(|c| placed(c)) {
                let element = format!("node {} `{}`", c.node, doc.node_name(c.node));
                return Err(doc.bad(element, "it is animated, and placed by a matrix"));
            }
            let mut character = Character {
                file: source.file_name.clone(),
                names: names.clone(),
                is_joint: is_joint.clone(),
                order: forest.order(),
                start: start.clone(),
                parents: forest.parent.clone(),
                rest: rest.clone(),
                clip,
                name: doc.animations[index].name.clone(),
                loops: false,
                unit: options.unit,
                turn: axes(options.up).0,
            };
            character.loops = character.ends_alike();
            Ok(character)
        };
        chosen.into_iter().for_each(|index| with(one(index)));
        Ok(())
    }

    /// The name of the file without folders.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The name of the animation.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Time of the last key frame \[s\].
    pub fn seconds(&self) -> f64 {
        self.clip.seconds()
    }

    /// Whether the last pose is the first one again, to 1 cm and 0.6 degrees for each node: then the animation repeats, else it ends in its
    /// last pose.
    pub fn loops(&self) -> bool {
        self.loops
    }

    /// Channels of the animation that move no node, such as the weights of morph targets.
    pub fn skipped(&self) -> usize {
        self.clip.skipped
    }

    /// The node of a name. Among several it is a joint of a skin, one that the animation moves by itself or by a node above it, and the first,
    /// in this order: exporters name meshes like joints, and skeletons have copies. O(nodes + channels x depth of each node of the name).
    pub fn node(&self, name: &str) -> Result<usize> {
        let named = (0..self.names.len()).rev().filter(|n| self.names[*n] == name);
        named.max_by_key(|n| (self.is_joint[*n], self.is_moved(*n))).ok_or_else(|| Error::Malformed {
            path: self.file.clone().into(),
            element: format!("node `{name}`"),
            problem: "the file has no node of this name, which a joint of the bundle or of the scene has".into(),
            hint: "give the file that the bundle was built from".into(),
        })
    }

    /// Whether the animation moves a node, or one above it.
    fn is_moved(&self, node: usize) -> bool {
        let mut above = std::iter::successors(Some(node), |n| self.parents[*n]);
        above.any(|n| self.clip.channels.iter().any(|c| c.node == n))
    }

    /// The transforms of all nodes to world space at `time` \[s\] since the start, column-major, in metres and Y up, as bundles are.
    pub fn worlds(&self, time: f64) -> Vec<[f64; 16]> {
        let seconds = self.seconds();
        self.pose(if self.loops && seconds > 0.0 { time.rem_euclid(seconds) } else { time })
    }

    /// The same on the way from the pose in which the skins of the file are bound, which has a `share` of 0, to that of the animation, of share 1.
    /// Clothes fit the body in that pose; most files have it for their nodes, others any pose. Rotations take the shorter way.
    pub fn worlds_between(&self, time: f64, share: f64) -> Vec<[f64; 16]> {
        let seconds = self.seconds();
        let locals = self.locals(if self.loops && seconds > 0.0 { time.rem_euclid(seconds) } else { time });
        self.place(&self.start.iter().zip(&locals).map(|(a, b)| a.towards(b, share)).collect::<Vec<_>>())
    }

    /// The same at a time of the animation, without repeats.
    fn pose(&self, time: f64) -> Vec<Matrix> {
        self.place(&self.locals(time))
    }

    fn locals(&self, time: f64) -> Vec<Local> {
        let mut locals = self.rest.clone();
        for channel in &self.clip.channels {
            let [x, y, z, w] = channel.at(time);
            if let Local::Parts { translation, rotation, scale } = &mut locals[channel.node] {
                match channel.target {
                    Target::Translation => *translation = [x, y, z],
                    Target::Rotation => *rotation = [x, y, z, w],
                    Target::Scale => *scale = [x, y, z],
                }
            }
        }
        locals
    }

    /// World transforms from those to parents.
    fn place(&self, locals: &[Local]) -> Vec<Matrix> {
        let mut worlds = vec![matrix::IDENTITY; locals.len()];
        for &n in &self.order {
            let own = locals[n].matrix();
            worlds[n] = self.parents[n].map_or(own, |p| matrix::mul(&worlds[p], &own));
        }
        worlds.iter().map(|m| matrix::mul(&self.turn, &matrix::in_unit(m, self.unit))).collect()
    }

    /// The same in the pose that the nodes of the file have, without the animation.
    pub fn rest_worlds(&self) -> Vec<[f64; 16]> {
        self.place(&self.rest)
    }

    fn ends_alike(&self) -> bool {
        let (first, last) = (self.pose(0.0), self.pose(self.seconds()));
        let near = |(a, b): (&Matrix, &Matrix)| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME_POSE);
        self.seconds() > 0.0 && first.iter().zip(&last).all(near)
    }
}

fn no_animation(path: &Path, name: &str, all: &[Animation]) -> Error {
    let names: Vec<String> = all.iter().map(|a| Value::from(a.name.as_str()).to_string()).collect();
    let has = if names.is_empty() { "it has none".into() } else { format!("it has {}", names.join(", ")) };
    Error::Option {
        option: "animation".into(),
        problem: format!("{} has no animation `{name}`", path.display()),
        hint: has,
    }
}

#[cfg(test)]
#[path = "character_tests.rs"]
mod tests;
