//! The arguments of commands that read garment files.

use std::path::PathBuf;

use clap::Args;
use gimage::backstops::Backstop;
use gimage::blend::BlendWidth;
use gimage::blends::Blend;
use gimage::caps::Caps;
use gimage::colliders::{ColliderOptions, ColliderSource, Guess, Kind, Tier};
use gimage::gate::GateOptions;
use gimage::import::Up;
use gimage::limits::Limit;
use gimage::options::help as help_of;
use gimage::options::{BuildOptions, Effort, ImageSize, RestLength, Sample, Seams};
use gimage::pins::{Pin, PinRule};
use gimage::render::{RenderMesh, Subdivision};
use gimage::select::{Pattern, SelectOptions};
use gimage::shell::Layer;
use gimage::stitch::Stitching;
use gimage::strands::Strands;

use super::values::{choice, collider_source, number, shape, size};

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
    #[arg(long, help = help_of("pins"), value_parser = choice::<PinRule>())]
    pub pins: Option<PinRule>,
    #[arg(long, help = help_of("limit"), value_name = "EXPR=METRES")]
    pub limit: Vec<Limit>,
    #[arg(long, help = help_of("backstop"), value_name = "EXPR=METRES[,RADIUS]")]
    pub backstop: Vec<Backstop>,
    #[arg(long, help = help_of("blend"), value_name = "EXPR=SHARE")]
    pub blend: Vec<Blend>,
    #[arg(long, help = help_of("blend-width"), value_name = "METRES", allow_negative_numbers = true)]
    pub blend_width: Option<BlendWidth>,
    #[arg(long, help = help_of("stitch"), value_name = "METRES", allow_negative_numbers = true)]
    pub stitch: Option<Stitching>,
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
    #[arg(long, help = help_of("render-mesh"), value_parser = choice::<RenderMesh>())]
    pub render_mesh: Option<RenderMesh>,
    #[arg(long, help = help_of("subdivide"), value_name = "CELLS", allow_negative_numbers = true)]
    pub subdivide: Option<Subdivision>,
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
    #[arg(long, help = help_of("strands"), value_parser = choice::<Strands>())]
    pub strands: Option<Strands>,
    #[arg(long, help = help_of("caps"), value_parser = choice::<Caps>())]
    pub caps: Option<Caps>,
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
    /// Largest number of colliders, 1 to 512; a skeleton with more joints that move the body has one per joint.
    #[arg(long, value_name = "N", default_value_t = 48, allow_negative_numbers = true)]
    pub max_colliders: usize,
    /// Shapes to choose from, separated by commas [default: sphere,capsule].
    #[arg(long, value_name = "SHAPE,...", value_delimiter = ',', value_parser = shape())]
    pub collider_shapes: Vec<Kind>,
    /// Take the colliders that the file has (KHR_physics_rigid_bodies, VRM), fit others, or (auto) take those of the file if 95 % of the
    /// body are within three times --collider-error of them.
    #[arg(long, value_name = "SOURCE", value_parser = collider_source(), default_value = "auto")]
    pub collider_source: ColliderSource,
    /// Colliders in place of parts of the body that the file leaves out beneath clothes, 0.7 times as wide as the innermost garment.
    #[arg(long, value_name = "GUESS", value_parser = choice::<Guess>(), default_value = "on")]
    pub collider_guess: Guess,
}

/// `gimage dress`.
#[derive(Debug, Args)]
pub struct DressArgs {
    #[command(flatten)]
    pub build: BuildArgs,
    #[command(flatten)]
    pub fit: FitArgs,
    /// The collider of cloth: the fitted colliders (capsules), the surface of the body, nearer to it for clothes that start outside of it, or (auto)
    /// the surface if at most 1 % of the free particles start more than 5 mm inside of it.
    #[arg(long, value_name = "KIND", default_value = "auto", value_parser = choice::<Tier>())]
    pub collider: Tier,
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
        options.assemble.rule = self.pins;
        options.assemble.limits.clone_from(&self.limit);
        options.assemble.backstops.clone_from(&self.backstop);
        options.assemble.blends.clone_from(&self.blend);
        options.blend.width = self.blend_width;
        set(&mut options.assemble.rest, self.rest);
        set(&mut options.stitch.stitch, self.stitch);
        options.gate =
            GateOptions { metrics: !self.no_metrics, accept_poor: self.accept_poor, min_psnr: self.min_psnr };
        set(&mut options.image.sample, self.sample);
        set(&mut options.image.seams, self.seams);
        set(&mut options.image.detail, self.detail);
        set(&mut options.image.effort, self.effort);
        set(&mut options.render.render_mesh, self.render_mesh);
        options.render.subdivide = self.subdivide;
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
        set(&mut options.strands.strands, self.strands);
        set(&mut options.caps.caps, self.caps);
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
        ColliderOptions {
            error: self.collider_error,
            count: self.max_colliders,
            kinds,
            source: self.collider_source,
            guess: self.collider_guess,
            ..ColliderOptions::default()
        }
    }
}

impl DressArgs {
    /// The options of the fit, and of the surface.
    pub fn colliders(&self) -> ColliderOptions {
        ColliderOptions { tier: self.collider, ..self.fit.options() }
    }
}

fn set<T>(option: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *option = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Dress {
        #[command(flatten)]
        args: DressArgs,
    }

    #[test]
    fn without_flags_the_options_are_those_of_the_library() {
        let args = Dress::try_parse_from(["dress", "mage.glb", "-o", "mage.gim"]).unwrap().args;
        assert_eq!(format!("{:?}", args.colliders()), format!("{:?}", ColliderOptions::default()));
        assert_eq!(format!("{:?}", args.build.options()), format!("{:?}", BuildOptions::default()));
    }
}
