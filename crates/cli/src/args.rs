//! The arguments of the command line. Parsing has no side effects: it touches no file, variable or thread.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use gimage::colliders::{ColliderOptions, Kind};
use gimage::gate::GateOptions;
use gimage::import::Up;
use gimage::limits::Limit;
use gimage::options::help as help_of;
use gimage::options::{BuildOptions, Choice, Effort, ImageSize, RestLength, Sample, Seams, range};
use gimage::pins::Pin;
use gimage::select::{Pattern, SelectOptions};
use gimage::shell::Layer;
use gimage_runtime::Material;

use crate::commands::character::MotionArgs;
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
    Inspect(BundleArgs),
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

/// `gimage build`.
#[derive(Debug, Args)]
pub struct BuildArgs {
    /// Garment files: .glb, .gltf or .obj.
    #[arg(required = true, value_name = "IN")]
    pub inputs: Vec<PathBuf>,
    /// The bundle to write; with several inputs, the directory for one <stem>.gim per input.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    #[arg(long, help = help_of("texels"), value_name = "N", group = "image_size", allow_negative_numbers = true)]
    pub texels: Option<u32>,
    #[arg(long, help = help_of("size"), value_name = "WxH", group = "image_size", value_parser = size)]
    pub size: Option<(u32, u32)>,
    #[arg(long, help = help_of("spacing"), value_name = "METRES", group = "image_size", value_parser = number("spacing"), allow_negative_numbers = true)]
    pub spacing: Option<f64>,
    #[arg(long, help = help_of("sample"), value_parser = choice::<Sample>())]
    pub sample: Option<Sample>,
    #[arg(long, help = help_of("seams"), value_parser = choice::<Seams>())]
    pub seams: Option<Seams>,
    #[arg(long, help = help_of("detail"), value_name = "SHARE", allow_negative_numbers = true)]
    pub detail: Option<f64>,
    #[arg(long, help = help_of("effort"), value_parser = choice::<Effort>())]
    pub effort: Option<Effort>,
    #[arg(long, help = help_of("piece"), value_name = "NAME")]
    pub piece: Vec<String>,
    #[command(flatten)]
    pub read: ReadArgs,
    #[arg(long, help = help_of("pin"), value_name = "EXPR")]
    pub pin: Vec<Pin>,
    #[arg(long, help = help_of("limit"), value_name = "EXPR=METRES")]
    pub limit: Vec<Limit>,
    #[arg(long, help = help_of("accessory-area"), value_name = "SHARE", allow_negative_numbers = true)]
    pub accessory_area: Option<f64>,
    #[arg(long, help = help_of("rest"), value_parser = choice::<RestLength>())]
    pub rest: Option<RestLength>,
    #[arg(long, help = help_of("density"), value_name = "KG_M2", value_parser = number("density"), allow_negative_numbers = true)]
    pub density: Option<f64>,
    #[arg(long, help = help_of("no-metrics"))]
    pub no_metrics: bool,
    #[arg(long, help = help_of("accept-poor"))]
    pub accept_poor: bool,
    #[arg(long, help = help_of("min-psnr"), value_name = "DB", allow_negative_numbers = true)]
    pub min_psnr: Option<f64>,
    /// Number of threads; 0 means one per core. The bundle does not depend on it.
    #[arg(long, value_name = "T", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024), allow_negative_numbers = true)]
    pub threads: u16,
    /// Write OUT.timings.json beside the bundle: time and memory per stage.
    #[arg(long)]
    pub timings: bool,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    pub json: bool,
    /// Replace an existing bundle.
    #[arg(long)]
    pub force: bool,
}

/// How a file is read, and its parts that become cloth: `gimage build` and `gimage list`.
#[derive(Debug, Args)]
pub struct ReadArgs {
    #[arg(long, help = help_of("cloth"), value_name = "NAME,...", value_delimiter = ',')]
    pub cloth: Vec<Pattern>,
    #[arg(long, help = help_of("body"), value_name = "NAME,...", value_delimiter = ',')]
    pub body: Vec<Pattern>,
    #[arg(long, help = help_of("rigid"), value_name = "NAME,...", value_delimiter = ',')]
    pub rigid: Vec<Pattern>,
    #[arg(long, help = help_of("unit"), value_name = "METRES", value_parser = number("unit"), allow_negative_numbers = true)]
    pub unit: Option<f64>,
    #[arg(long, help = help_of("up"), value_name = "AXIS", allow_hyphen_values = true)]
    pub up: Option<Up>,
    #[arg(long, help = help_of("center"))]
    pub center: bool,
    #[arg(long, help = help_of("weld"), value_name = "METRES", value_parser = number("weld"), allow_negative_numbers = true)]
    pub weld: Option<f64>,
    #[arg(long, help = help_of("shell"), value_parser = choice::<Layer>())]
    pub shell: Option<Layer>,
}

/// `gimage list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    /// Garment file: .glb, .gltf or .obj.
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    #[command(flatten)]
    pub read: ReadArgs,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    pub json: bool,
}

/// How colliders are fitted to a body.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Distance that at most 5 % of the body may have from the colliders; they are divided until then.
    #[arg(long, value_name = "METRES", default_value_t = 0.006, allow_negative_numbers = true)]
    pub collider_error: f64,
    /// Largest number of colliders, beyond one per joint; 1 to 512.
    #[arg(long, value_name = "N", default_value_t = 48, allow_negative_numbers = true)]
    pub max_colliders: usize,
    /// Shapes to choose from, separated by commas [default: sphere,capsule].
    #[arg(long, value_name = "SHAPE,...", value_delimiter = ',', value_parser = shape())]
    pub collider_shapes: Vec<Kind>,
}

/// `gimage dress`.
#[derive(Debug, Args)]
pub struct DressArgs {
    #[command(flatten)]
    pub build: BuildArgs,
    #[command(flatten)]
    pub fit: FitArgs,
}

/// `gimage fit-colliders`.
#[derive(Debug, Args)]
pub struct FitCollidersArgs {
    /// Character file: .glb, .gltf or .obj.
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// A scene file to write, with the colliders alone.
    #[arg(short, long, value_name = "SCENE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub fit: FitArgs,
    #[command(flatten)]
    pub read: ReadArgs,
    /// Replace an existing file.
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// `gimage inspect` and `gimage validate`.
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

/// The scene and its solver: `gimage simulate` and `gimage render`.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// The name of a built-in scene, a scene file (.json), or a bundle.
    #[arg(value_name = "SCENE")]
    pub scene: String,
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
    /// Tethers per particle to the nearest pins, 0 to 4; xpbd only [default: that of the scene, or 2].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub tethers: Option<u32>,
    /// Limit lengths on coarser grids every K steps, 0 for never; for cloth that flies freely, not for cloth on colliders;
    /// xpbd only [default: that of the scene, or 0].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub pyramid: Option<u32>,
    /// Additional rounds of tethers and structural springs after each relaxation, 0 to 64, for cloth on colliders and fine
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
    #[command(flatten)]
    pub motion: MotionArgs,
    /// Particles per side of a built-in scene.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(2..=4095), allow_negative_numbers = true)]
    pub n: u32,
    /// Number of CPU threads; 0 means one per core. The result does not depend on it.
    #[arg(long, value_name = "T", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024), allow_negative_numbers = true)]
    pub threads: u16,
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
            Command::Inspect(args) | Command::Validate(args) => args.json,
            Command::Simulate(args) => args.json,
            Command::Render(args) => args.json,
            Command::CheckCrossings(args) => args.json,
            Command::Doctor(args) => args.json,
            Command::Reconstruct(_) => false,
        }
    }
}

impl BuildArgs {
    /// The options of the library; omitted ones keep their defaults. The library checks the ranges.
    pub fn options(&self) -> BuildOptions {
        let mut options = self.read.options();
        let size = (self.size.map(|(w, h)| ImageSize::Exact(w, h)))
            .or(self.spacing.map(ImageSize::Spacing))
            .or(self.texels.map(ImageSize::Texels));
        set(&mut options.image.size, size);
        options.import.pieces.clone_from(&self.piece);
        set(&mut options.component.accessory_area, self.accessory_area);
        set(&mut options.mass.density, self.density);
        options.assemble.pins.clone_from(&self.pin);
        options.assemble.limits.clone_from(&self.limit);
        set(&mut options.assemble.rest, self.rest);
        options.gate =
            GateOptions { metrics: !self.no_metrics, accept_poor: self.accept_poor, min_psnr: self.min_psnr };
        set(&mut options.image.sample, self.sample);
        set(&mut options.image.seams, self.seams);
        set(&mut options.image.detail, self.detail);
        set(&mut options.image.effort, self.effort);
        options
    }
}

impl ReadArgs {
    /// The options of a build that reads a file in this way.
    pub fn options(&self) -> BuildOptions {
        let mut options = BuildOptions::default();
        set(&mut options.import.unit, self.unit);
        set(&mut options.import.up, self.up);
        options.import.center = self.center;
        options.select =
            SelectOptions { cloth: self.cloth.clone(), body: self.body.clone(), rigid: self.rigid.clone() };
        options.repair.weld = self.weld.or(options.repair.weld);
        set(&mut options.shell.shell, self.shell);
        options
    }
}

impl ListArgs {
    /// The options of a build that reads the file in this way.
    pub fn options(&self) -> BuildOptions {
        self.read.options()
    }
}

impl FitArgs {
    /// The options of the fit.
    pub fn options(&self) -> ColliderOptions {
        let mut kinds = self.collider_shapes.clone();
        kinds.sort_unstable();
        kinds.dedup();
        let kinds = if kinds.is_empty() { ColliderOptions::default().kinds } else { kinds };
        ColliderOptions { error: self.collider_error, count: self.max_colliders, kinds }
    }
}

fn set<T>(option: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *option = value;
    }
}

/// Reads a number in the range of an option of the library.
fn number(name: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse::<f64>().map_err(|_| format!("`{text}` is not a number"))?;
        let range = range(name);
        if range.holds(&[number]) { Ok(number) } else { Err(format!("give {}", range.words())) }
    }
}

/// Reads one of the words of an option of the library.
fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let words = PossibleValuesParser::new(T::ALL.iter().map(|(name, _)| *name));
    words.try_map(|word| T::ALL.iter().find(|(name, _)| *name == word).map(|(_, value)| *value).ok_or("not a choice"))
}

/// Reads the name of a shape.
fn shape() -> impl TypedValueParser<Value = Kind> {
    let words = PossibleValuesParser::new(Kind::ALL.map(Kind::name));
    words.try_map(|word| Kind::ALL.into_iter().find(|k| k.name() == word).ok_or("not a shape"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().map_err(|_| format!("`{text}` is not a number"))?;
    if number.is_finite() && number >= 0.0 { Ok(number) } else { Err("give at least 0 seconds, as in 0.5".into()) }
}

fn material(text: &str) -> Result<Material, String> {
    let first = text.split(',').next().unwrap_or("").trim();
    let fabric = Material::named(first);
    let skipped = usize::from(fabric.is_some());
    if fabric.is_none() && !first.contains('=') {
        let names: Vec<_> = Material::names().collect();
        return Err(format!("`{first}` is neither NAME=NUMBER nor one of {}", names.join(", ")));
    }
    let mut material = fabric.unwrap_or_default();
    for part in text.split(',').skip(skipped) {
        let (name, number) = part.split_once('=').ok_or_else(|| format!("`{part}` is not NAME=NUMBER"))?;
        let field = match name.trim() {
            "warp" => &mut material.warp,
            "weft" => &mut material.weft,
            "shear" => &mut material.shear,
            "bend" => &mut material.bend,
            "density" => &mut material.density,
            "damping" => &mut material.damping,
            "friction" => &mut material.friction,
            "thickness" => material.thickness.insert(0.0),
            other => {
                let names = "warp, weft, shear, bend, density, damping, friction, thickness";
                return Err(format!("`{other}` is not one of {names}"));
            }
        };
        *field = number.trim().parse().map_err(|_| format!("`{number}` is not a number"))?;
    }
    material.check().map(|()| material).map_err(|e| e.to_string())
}

fn camera(text: &str) -> Result<[f32; 6], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let six = numbers.and_then(|n| n.try_into().ok());
    six.ok_or_else(|| "give eye and target as six numbers, as in 0,1,3,0,1,0".into())
}

fn color(text: &str) -> Result<[f32; 3], String> {
    let code = u32::from_str_radix(text, 16).ok().filter(|_| text.len() == 6);
    let code = code.ok_or("give six hexadecimal digits, as in ffffff")?;
    Ok([16, 8, 0].map(|shift| (code >> shift & 255) as f32 / 255.0))
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    sides.ok_or_else(|| "give width and height as in 128x96".into())
}

#[cfg(test)]
#[path = "args_tests.rs"]
mod tests;
