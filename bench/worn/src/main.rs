//! Measures how deep cloth gets inside of the body mesh of dressed characters, at rest and in motion. CSV to stdout.

mod judge;
mod model;
mod run;

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use gimage_bench_host::Gpu;
use model::Model;

type Error = Box<dyn std::error::Error>;

/// Characters of the table: file, parts that are cloth (none: by the rule of `gimage dress`), animations.
const TABLE: [(&str, &[&str], &[&str]); 4] = [
    ("figure.glb", &[], &["Walk", "Turn", "Sit"]),
    ("mage_skinned.glb", &[], &["Walking_A"]),
    ("knight_skinned/scene.gltf", &["Object_8"], &["Take 001"]),
    ("outfit_skinned.glb", &[], &[model::SWAY]),
];

/// How deep the free particles of a dressed character get inside of the mesh of its body, which joints move: nearest point and side by parry3d. CSV
/// to stdout, the adapter to stderr.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  worn > worn.csv\n  worn --cpu assets/figure.glb --animation Walk,Turn --collider capsules"
)]
struct Args {
    /// A character file, or a bundle with the surface of its body; without one, the figure of assets and the skinned characters of the shared garments.
    file: Option<PathBuf>,
    /// Its animations, separated by commas; `sway` turns all joints slightly, for files without any.
    #[arg(long, value_delimiter = ',', default_value = model::SWAY)]
    animation: Vec<String>,
    /// Its parts that are cloth, separated by commas; none: those that `gimage dress` takes.
    #[arg(long, value_delimiter = ',')]
    cloth: Vec<String>,
    /// Texels of a character.
    #[arg(long, default_value_t = 4096)]
    texels: u32,
    /// Seconds of each animation.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Seconds on the GPU.
    #[arg(long, default_value_t = 10.0)]
    gpu_seconds: f64,
    /// Collider of the body.
    #[arg(long, value_enum, default_value_t = Collider::Surface)]
    collider: Collider,
    /// Only the CPU backend.
    #[arg(long, conflicts_with = "gpu")]
    cpu: bool,
    /// Only the GPU backend.
    #[arg(long)]
    gpu: bool,
    /// Prints the particles deeper than this many millimetres in motion to stderr.
    #[arg(long)]
    deeper: Option<f64>,
}

/// Colliders of the body.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Collider {
    Surface,
    Capsules,
    /// As `--collider auto` of `gimage dress`.
    Auto,
}

#[allow(clippy::print_stdout)]
fn main() -> Result<(), Error> {
    let args = Args::parse();
    let gpu = if args.cpu { Err("not asked for".into()) } else { Gpu::new() };
    match &gpu {
        Ok(Gpu { info, .. }) => eprintln!("adapter: {} ({:?}), {}", info.name, info.device_type, info.driver_info),
        Err(error) => eprintln!("no adapter, CPU backend only: {error}"),
    }
    let gpu = gpu.ok();
    let owned = |list: &[&str]| list.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let list = match &args.file {
        Some(file) => vec![(file.clone(), args.cloth.clone(), args.animation.clone())],
        None => {
            let file = |name: &str| gimage_bench_meshes::asset(name).or(gimage_bench_meshes::shared(&[name]).pop());
            let of = |(name, cloth, animations): &(&str, &[&str], &[&str])| {
                Some((file(name)?, owned(cloth), owned(animations)))
            };
            TABLE.iter().filter_map(of).collect()
        }
    };
    println!("{}", run::HEADER);
    for (file, cloth, animations) in list {
        for animation in animations {
            let model = Model::new(&file, &animation, &cloth, args.texels, args.collider)?;
            let cpu = (!args.gpu).then_some((None, args.seconds));
            for (gpu, seconds) in cpu.into_iter().chain(gpu.as_ref().map(|gpu| (Some(gpu), args.gpu_seconds))) {
                println!("{}", run::row(&model, gpu, seconds, args.deeper)?);
            }
        }
    }
    Ok(())
}
