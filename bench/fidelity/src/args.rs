//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use gimage::gate::GateOptions;
use gimage::options::{BuildOptions, Effort, ImageSize, PieceOptions, Sample, Seams};

/// Measures builds: CPU time, memory and faithfulness, as a table and a plot.
#[derive(Debug, Parser)]
#[command(name = "fidelity", version, args_conflicts_with_subcommands = true)]
pub struct Cli {
    /// Something else than the benchmark.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The benchmark.
    #[command(flatten)]
    pub bench: BenchArgs,
}

/// Parts of the benchmark that run on their own.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// One build, measured, as JSON; what the benchmark runs as a child.
    #[command(hide = true)]
    One(OneArgs),
    /// Draws the plot of a finished run again.
    Plot(PlotArgs),
}

/// The measurement to run.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Meshes; without any, the sample garments and the clean ones of the shared garments.
    pub meshes: Vec<PathBuf>,
    /// Name of the run: the folder its files go to.
    #[arg(long, default_value = "latest")]
    pub name: String,
    /// Folder of the runs.
    #[arg(long, default_value = "bench/runs", value_name = "DIR")]
    pub runs: PathBuf,
    /// Sides of the squares that set the texel budgets.
    #[arg(long, value_delimiter = ',', default_value = "65,129,257,513", value_parser = clap::value_parser!(u32).range(9..=4096))]
    pub texels: Vec<u32>,
    /// Where texels go.
    #[arg(long, value_delimiter = ',', default_value = "point,fit")]
    pub sample: Vec<SampleArg>,
    /// Which edges the cut prefers.
    #[arg(long, value_delimiter = ',', default_value = "auto,short")]
    pub seams: Vec<SeamsArg>,
    /// How hard the search for a layout tries.
    #[arg(long, value_delimiter = ',', default_value = "default")]
    pub effort: Vec<EffortArg>,
    /// How far texels go where the surface bends, each 0 to 1.
    #[arg(long, value_delimiter = ',', default_value = DETAIL)]
    pub detail: Vec<f64>,
    /// Timed builds of each setting; minimum and median are reported.
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeat: u32,
    /// Threads of a build, 0 for one a core.
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub threads: u32,
    /// Also run these peers (slim, xatlas); without names, both.
    #[arg(long, value_delimiter = ',', num_args = 0..=1, require_equals = true, default_missing_value = "slim,xatlas")]
    pub peers: Vec<PeerArg>,
    /// Texel sides of the peers' images; without any, those of --texels.
    #[arg(long, value_delimiter = ',', value_name = "TEXELS")]
    pub peer_texels: Vec<u32>,
    /// Also score everything with an independent program: path to its score.py.
    #[arg(long, value_name = "PATH")]
    pub scorer: Option<PathBuf>,
    /// The Python that runs peers and scorer.
    #[arg(long, default_value = "python3")]
    pub python: PathBuf,
}

/// One build.
#[derive(Debug, Args)]
pub struct OneArgs {
    /// The mesh.
    pub mesh: PathBuf,
    /// Side of the square that sets the texel budget.
    #[arg(long)]
    pub texels: u32,
    /// Where texels go.
    #[arg(long)]
    pub sample: SampleArg,
    /// Which edges the cut prefers.
    #[arg(long)]
    pub seams: SeamsArg,
    /// How hard the search for a layout tries.
    #[arg(long)]
    pub effort: EffortArg,
    /// How far texels go where the surface bends.
    #[arg(long)]
    pub detail: f64,
    /// Where the bundle goes.
    #[arg(long)]
    pub out: PathBuf,
    /// Measure the quality too; such a build is not timed.
    #[arg(long)]
    pub metrics: bool,
}

/// A plot to draw again.
#[derive(Debug, Args)]
pub struct PlotArgs {
    /// The run's table.
    pub csv: PathBuf,
}

/// [`Sample`] by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SampleArg {
    /// On the surface.
    Point,
    /// By least squares.
    Fit,
}

/// [`Seams`] by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SeamsArg {
    /// Both tried, the better kept.
    Auto,
    /// The shortest cut.
    Short,
    /// Along UV seams.
    Uv,
}

/// [`Effort`] by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EffortArg {
    /// One rough search.
    Fast,
    /// The default effort of `gimage build`.
    Default,
    /// Several times as long.
    Best,
}

/// The default detail of `gimage build`.
pub const DETAIL: &str = "0.6";

/// A peer by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PeerArg {
    /// libigl's SLIM on one square chart a piece.
    Slim,
    /// xatlas: many charts in one atlas.
    Xatlas,
}

/// The name of a value as the command line spells it.
pub fn name(value: impl ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

impl OneArgs {
    /// The options of this build.
    pub fn options(&self) -> BuildOptions {
        let image = PieceOptions {
            size: ImageSize::Texels(self.texels * self.texels),
            sample: match self.sample {
                SampleArg::Point => Sample::Point,
                SampleArg::Fit => Sample::Fit,
            },
            seams: match self.seams {
                SeamsArg::Auto => Seams::Auto,
                SeamsArg::Short => Seams::Short,
                SeamsArg::Uv => Seams::Uv,
            },
            effort: match self.effort {
                EffortArg::Fast => Effort::Fast,
                EffortArg::Default => Effort::Default,
                EffortArg::Best => Effort::Best,
            },
            detail: self.detail,
        };
        let gate = GateOptions { metrics: self.metrics, ..GateOptions::default() };
        BuildOptions { image, gate, ..BuildOptions::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound_and_its_defaults_are_those_documented() {
        Cli::command().debug_assert();
        let cli = Cli::parse_from(["fidelity"]);
        assert_eq!(cli.bench.texels, [65, 129, 257, 513]);
        assert!(cli.bench.peers.is_empty() && cli.bench.repeat == 3);
        let options = BuildOptions::default();
        assert_eq!((cli.bench.detail[0], options.image.effort), (options.image.detail, Effort::Default));
    }

    #[test]
    fn peers_without_names_are_all_of_them_and_take_no_mesh_for_a_name() {
        let cli = Cli::parse_from(["fidelity", "--peers", "a.obj"]);
        assert_eq!(cli.bench.peers, [PeerArg::Slim, PeerArg::Xatlas]);
        assert_eq!(cli.bench.meshes, [PathBuf::from("a.obj")]);
        assert_eq!(Cli::parse_from(["fidelity", "--peers=slim"]).bench.peers, [PeerArg::Slim]);
    }
}
