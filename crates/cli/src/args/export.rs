//! The arguments of `gimage export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::SceneArgs;
use super::values::rate;
use crate::commands::surface::SurfaceArg;

/// `gimage export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The file to write, .glb or .usda; .obj writes a file per frame, OUT_00001.obj and so on.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// The surface to write: render, the mesh of the source in the bundle (render.glb), with its texture coordinates, and in a .glb its
    /// materials and textures; grid, the particles; auto, render for a bundle that has one, grid for a scene file.
    #[arg(long, value_enum, default_value_t = SurfaceArg::Auto)]
    pub surface: SurfaceArg,
    /// Number of frames of 1/60 s to simulate [default: that of the scene, 600 for a bundle].
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    pub frames: Option<u32>,
    /// Keep every K-th frame.
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    pub every: u32,
    /// Keep this number of frames per second instead, at most 1000, for example 24; between two steps, positions are interpolated.
    #[arg(long, value_name = "FPS", conflicts_with = "every", value_parser = rate, allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// First frame of 1/60 s to keep.
    #[arg(long, value_name = "FRAME", default_value_t = 0, allow_negative_numbers = true)]
    pub from: u32,
    /// How a .glb shows frames: targets, morph targets with animated weights; meshes, a mesh per frame that is scaled from 0 to 1,
    /// for tools that limit the number of targets [default: targets].
    #[arg(long = "as", value_enum)]
    pub shown: Option<ShownArg>,
    /// How a .glb is compressed: meshopt (EXT_meshopt_compression; numbers are rounded by at most 2^-17 of the largest of a vector), or draco
    /// (KHR_draco_mesh_compression; 16 bits over the box of the mesh), with --as meshes.
    #[arg(long, value_enum, value_name = "CODEC", default_value_t = CompressArg::None)]
    pub compress: CompressArg,
    /// Replace existing files, and remove the frames of an older .obj sequence.
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// How a .glb is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompressArg {
    None,
    Meshopt,
    Draco,
}

/// How a .glb shows frames.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ShownArg {
    Targets,
    Meshes,
}
