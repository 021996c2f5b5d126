//! Scenes as JSON text. The format is described in SCENE.md, which is normative.

mod error;
mod json;
mod make;

pub use error::{Error, Result};
pub use json::Source;

use gimage_bundle::Bundle;

use super::{Scene, Script};
use crate::look::{Camera, Look, SolidLook};
use crate::options::Options;

/// Most bytes of a scene file: 16 MiB.
pub const MAX_BYTES: usize = 16 << 20;

/// A scene, what happens in it, and how to look at it.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// The scene at its start. `frames` is the file's duration in frames of `options.step`.
    pub scene: Scene,
    /// Whether the scene is to be cleared at its start: call [`Scene::clear_start`] once joints and colliders are where they begin. `None` leaves that
    /// to [`Scene::is_to_clear`].
    pub clear_start: Option<bool>,
    /// The script: call [`Script::frame`] before each frame.
    pub script: Script,
    /// Solver settings; the file does not set backend and threads.
    pub options: Options,
    /// The camera, if the file has one.
    pub camera: Option<Camera>,
    /// sRGB, 0 to 1, if the file has one.
    pub background: Option<[f32; 3]>,
    /// How each cloth is drawn.
    pub looks: Vec<Look>,
    /// How colliders are drawn.
    pub solid_look: SolidLook,
    /// The character whose animation moves joints, if the file has one. The host reads its file: cloths with a skin follow it
    /// ([`crate::Cloth::follow_joints`]), and so do colliders with a joint.
    pub character: Option<CharacterFile>,
    /// Where each cloth comes from, `None` for a flat one; empty for a scene that was not read from a file.
    pub sources: Vec<Option<Source>>,
    /// The joint that each collider moves with, `None` for one that moves with none; its pose is that in the pose of the character's file.
    pub joints: Vec<Option<String>>,
}

/// A character and an animation of it, by their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CharacterFile {
    /// Path of the file, relative to the scene file.
    pub file: String,
    /// Name of the animation.
    pub animation: String,
}

/// The answer of a host if a scene names a bundle or a garment.
pub type Found = std::result::Result<Bundle, Box<dyn std::error::Error + Send + Sync>>;

impl SceneFile {
    /// Reads a scene. `find` is asked for the bundle of each cloth that is not flat; nothing here opens files. Unknown
    /// fields are refused. Errors name the field and what to do. Costs the bundles and time linear in their particles.
    pub fn parse(bytes: &[u8], mut find: impl FnMut(&Source) -> Found) -> Result<Self> {
        make::scene(json::read(bytes)?, &mut find)
    }
}

#[cfg(test)]
#[path = "file/tests.rs"]
mod tests;
