//! The arguments of the command line. Parsing has no side effects: it touches no file, variable or thread.

mod export;
mod garment;
mod values;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use gimage_runtime::Material;

pub use export::{CompressArg, ExportArgs, ShownArg};
pub use garment::{BuildArgs, DressArgs, FitCollidersArgs, ListArgs};
use values::{camera, color, material, seconds, size};

use crate::commands::character::MotionArgs;
use crate::commands::surface::SurfaceArg;
use crate::help;

/// Turn garment meshes into geometry images.
#[derive(Debug, Parser)]
#[command(name = "gimage", version, arg_required_else_help = true, after_help = help::TOP, max_term_width = 100)]
pub struct Cli {
    /// Print only errors on stderr.
    #[arg(short, long, global = true, conflicts_with = "verbose", display_order = 900)]
    pub quiet: bool,
    /// List everything: notes, all accessories, all options.
    #[arg(short, long, global = true, display_order = 901)]
    pub verbose: bool,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Build a bundle of geometry images from each garment file.
    #[command(after_help = help::BUILD)]
    Build(Box<BuildArgs>),
    /// List what is in a garment file: parts, components, boundary loops, skins, animations.
    #[command(after_help = help::LIST)]
    List(ListArgs),
    /// Show the contents and the quality of a bundle.
    #[command(after_help = help::INSPECT)]
    Inspect(InspectArgs),
    /// Check a bundle against the rules of the format, texel by texel.
    #[command(after_help = help::VALIDATE)]
    Validate(BundleArgs),
    /// Convert a bundle back to one welded mesh.
    #[command(after_help = help::RECONSTRUCT)]
    Reconstruct(ReconstructArgs),
    /// Simulate a scene, or a bundle under gravity, and print its times.
    #[command(after_help = help::SIMULATE)]
    Simulate(SimulateArgs),
    /// Simulate a scene and draw it: a PNG, or a GIF of many pictures.
    #[command(after_help = help::RENDER)]
    Render(RenderArgs),
    /// Simulate a scene and write its motion for film and game tools: glTF, USD or OBJ.
    #[command(after_help = help::EXPORT)]
    Export(ExportArgs),
    /// Build the cloth of a character, with colliders in place of its body.
    #[command(after_help = help::DRESS)]
    Dress(Box<DressArgs>),
    /// Fit capsules, boxes and ellipsoids to the body of a character, for cloth to collide with.
    #[command(after_help = help::FIT_COLLIDERS)]
    FitColliders(FitCollidersArgs),
    /// Count triangles of cloth that cross, in dumped frames and in bundles at rest.
    #[command(after_help = help::CHECK_CROSSINGS)]
    CheckCrossings(CheckCrossingsArgs),
    /// List the GPU adapters of this machine, check their results, and show which one would run.
    #[command(after_help = help::DOCTOR)]
    Doctor(DoctorArgs),
}

/// `gimage inspect`.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// The bundle.
    #[arg(value_name = "BUNDLE")]
    pub bundle: PathBuf,
    /// Draw the cloth at rest to this PNG, with the triangles that cross in red: all of it, and the place where they cross most deeply.
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
    /// Overwrite the picture.
    #[arg(long, requires = "picture")]
    pub force: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `gimage validate`.
#[derive(Debug, Args)]
pub struct BundleArgs {
    /// The bundle.
    #[arg(value_name = "BUNDLE")]
    pub bundle: PathBuf,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `gimage reconstruct`.
#[derive(Debug, Args)]
pub struct ReconstructArgs {
    /// The bundle.
    #[arg(value_name = "BUNDLE")]
    pub bundle: PathBuf,
    /// The mesh to write, .obj or .glb.
    #[arg(short, long, value_name = "MESH")]
    pub output: PathBuf,
    /// Replace an existing file.
    #[arg(long)]
    pub force: bool,
}

/// The scene and its solver: `gimage simulate`, `gimage render` and `gimage export`.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// The name of a built-in scene, a scene file (.json), or a bundle.
    #[arg(value_name = "SCENE", required_unless_present = "named")]
    scene: Option<String>,
    /// The same as SCENE.
    #[arg(long = "scene", id = "named", value_name = "SCENE", conflicts_with = "scene")]
    named: Option<String>,
    /// Where to compute; auto is a hardware GPU that passes its self-check (see gimage doctor), else the CPU.
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: BackendArg,
    /// Solver of the springs [default: that of the scene, or xpbd].
    #[arg(long, value_enum)]
    pub solver: Option<SolverArg>,
    /// Steps per frame [default: that of the scene, or chosen from what holds the cloth, its size and speeds].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub substeps: Option<u32>,
    /// Choose the number of steps per frame, starting at --substeps, so that they take at most this time [default: that of
    /// the scene].
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub budget: Option<f64>,
    /// Choose the cheapest numbers of steps per frame and rounds of polish that leave at most this stretch, 0.01 for 1 %;
    /// --budget wins [default: that of the scene].
    #[arg(long, value_name = "STRETCH", allow_negative_numbers = true)]
    pub error: Option<f64>,
    /// Relaxations per step [default: that of the scene, or 1].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub iterations: Option<u32>,
    /// Most tethers per particle, each to the nearest pin of another group of pins, 0 to 4; xpbd only [default: that of the scene, or 4].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub tethers: Option<u32>,
    /// Limit lengths on coarser grids every K steps, 0 for never; for cloth that flies freely, not for cloth on colliders;
    /// xpbd only [default: that of the scene, or 0].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub pyramid: Option<u32>,
    /// Additional rounds of structural springs after each relaxation, 0 to 64, for cloth on colliders and fine
    /// cloth on tethers; xpbd only [default: that of the scene, or chosen with the substeps; 0 if --substeps is given].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub polish: Option<u32>,
    /// Distance that particles keep from colliders, 0 to 1 m: half the thickness of the cloth; for cloth without a thickness
    /// of its own [default: that of the scene, or 0].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub thickness: Option<f32>,
    /// Material of all cloth: a fabric (silk, cotton, denim, wool, leather, felt, rubber), numbers, or both, separated by
    /// commas: warp=500,weft=400,shear=40 (N/m), bend=1e-5 (N m), density=0.15 (kg/m2), damping=0.5 (1/s), friction=1 (factor
    /// of the friction of colliders), thickness=0.001 (m). Omitted values are those of the fabric, or have these defaults; an
    /// omitted thickness stays as it is. xpbd only [default: that of the scene, or springs].
    #[arg(long, value_name = "FABRIC,NAME=NUMBER,...", value_parser = material)]
    pub material: Option<Material>,
    /// Contact of all cloth with itself and with other cloth: particles pushes particles apart that are nearer than the distance
    /// of neighbours; safe also lets no triangle cross another one; both take cloth apart that crosses at the start, on the CPU; xpbd
    /// only [default: that of the scene, or off].
    #[arg(long, value_enum)]
    pub contact: Option<ContactArg>,
    /// Move free particles out of the body, the colliders and, with contact, the garments below that they begin in, before the first
    /// frame; auto is on for a bundle, as a scene file has it, and else on where the first frame would throw cloth out of colliders.
    #[arg(long, value_enum, default_value_t = ClearStartArg::Auto)]
    pub clear_start: ClearStartArg,
    #[command(flatten)]
    pub motion: MotionArgs,
    /// Particles per side of a built-in scene.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(2..=4095), allow_negative_numbers = true)]
    pub n: u32,
    /// Number of CPU threads; 0 means one per core. The result does not depend on it.
    #[arg(long, value_name = "T", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024), allow_negative_numbers = true)]
    pub threads: u16,
}

impl SceneArgs {
    /// The scene, by position or by flag.
    pub fn scene(&self) -> &str {
        self.scene.as_deref().or(self.named.as_deref()).unwrap_or_default()
    }
}

/// `gimage simulate`.
#[derive(Debug, Args)]
pub struct SimulateArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Number of frames of 1/60 s [default: that of the scene, 600 for a bundle].
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub frames: Option<u32>,
    /// Write the positions of each frame to this directory.
    #[arg(long, value_name = "DIR")]
    pub dump: Option<PathBuf>,
    /// Dump every K-th frame.
    #[arg(long, value_name = "K", default_value_t = 1, requires = "dump", value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    pub every: u32,
    /// First frame to dump.
    #[arg(long, value_name = "FRAME", default_value_t = 0, requires = "dump", allow_negative_numbers = true)]
    pub dump_from: u32,
    /// Remove frames of an older run from the directory of --dump.
    #[arg(long, requires = "dump")]
    pub force: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `gimage render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The picture to write, .png or .gif.
    #[arg(short, long, value_name = "PICTURE")]
    pub output: PathBuf,
    /// Size in pixels, for example 640x480.
    #[arg(long, value_name = "WxH", default_value = "640x480", value_parser = size)]
    pub size: (u32, u32),
    /// Time of the picture, or of the last picture of a GIF, at most 86400 [default: the end of the scene; 0 for a still
    /// picture of a bundle without pins].
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Number of pictures of a GIF, the last one at --time [default: all from the start].
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u32).range(1..=10_000), allow_negative_numbers = true)]
    pub frames: Option<u32>,
    /// Frame rate of a GIF, at most 50 pictures per second.
    #[arg(long, value_name = "FPS", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=50), allow_negative_numbers = true)]
    pub fps: u32,
    /// Position and target of the camera in metres [default: that of the scene, or one that shows everything].
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = camera, allow_hyphen_values = true)]
    pub camera: Option<[f32; 6]>,
    /// Vertical field of view [default: that of the scene, or 35].
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub fov: Option<f32>,
    /// The surface of the cloth: render, the mesh of the source in the bundle (render.glb), with its textures; grid, the particles; auto,
    /// render for a bundle that has one, grid for a scene file.
    #[arg(long, value_enum, default_value_t = SurfaceArg::Auto)]
    pub surface: SurfaceArg,
    /// A ground with a soft shadow: auto, under a character that is animated.
    #[arg(long, value_enum, default_value_t = GroundArg::Auto)]
    pub ground: GroundArg,
    /// Draw the colliders of a character in place of its body.
    #[arg(long)]
    pub colliders: bool,
    /// Background colour, sRGB, for example ffffff [default: that of the scene, or f4f4f2].
    #[arg(long, value_name = "RRGGBB", value_parser = color)]
    pub background: Option<[f32; 3]>,
    /// Replace an existing file.
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `gimage check-crossings`.
#[derive(Debug, Args)]
pub struct CheckCrossingsArgs {
    /// Directories of `gimage simulate --dump`, and bundles.
    #[arg(required = true, value_name = "DUMP_OR_BUNDLE")]
    pub inputs: Vec<PathBuf>,
    /// The scene whose frames were dumped: the name of a built-in scene, a scene file (.json), or a bundle. Needed for cloth of
    /// several pieces.
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<String>,
    /// Particles per side of a built-in scene.
    #[arg(long, value_name = "N", default_value_t = 32, requires = "scene", value_parser = clap::value_parser!(u32).range(2..=4095), allow_negative_numbers = true)]
    pub n: u32,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `gimage doctor`.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

// The values have no help texts: the flag describes them, so that the help stays short.

/// Where to compute.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum BackendArg {
    Auto,
    Gpu,
    Cpu,
}

/// Whether pictures have a ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GroundArg {
    Auto,
    On,
    Off,
}

/// Whether particles leave what they begin in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClearStartArg {
    Auto,
    On,
    Off,
}

/// Contact of cloth with cloth.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ContactArg {
    Off,
    Particles,
    Safe,
}

/// The solver of springs.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SolverArg {
    Classic,
    Xpbd,
}

impl Cli {
    /// Whether stdout gets JSON.
    pub fn json(&self) -> bool {
        match &self.command {
            Command::Build(args) => args.json,
            Command::Dress(args) => args.build.json,
            Command::List(args) => args.json,
            Command::FitColliders(args) => args.json,
            Command::Inspect(args) => args.json,
            Command::Validate(args) => args.json,
            Command::Simulate(args) => args.json,
            Command::Render(args) => args.json,
            Command::Export(args) => args.json,
            Command::CheckCrossings(args) => args.json,
            Command::Doctor(args) => args.json,
            Command::Reconstruct(_) => false,
        }
    }
}

#[cfg(test)]
#[path = "args_tests.rs"]
mod tests;
