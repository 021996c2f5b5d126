//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use gimage::options::{BuildOptions, ImageSize, PieceOptions, Sample};
use gimage::repair::RepairOptions;

/// Builds many meshes, each in a child process, and reports what came out.
///
/// Exit status: 0 all requirements hold, 1 one is violated (the table names them), 2 the sweep could not run.
#[derive(Debug, Parser)]
#[command(name = "sweep", version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
pub struct Cli {
    /// The child.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The sweep.
    #[command(flatten)]
    pub sweep: SweepArgs,
}

const EXAMPLES: &str = "Examples:
  sweep garments --csv garments.csv                 every .obj, .glb and .gltf under a folder
  sweep --hard --count 1000 --shard 2/5             the second fifth of 1,000 generated hard meshes
  sweep --hard --filter 'lace-*' --write-meshes out lace only; the meshes are kept as OBJ files
  sweep --damaged --count 3000 --csv damaged.csv    sample garments, each damaged on purpose
  sweep --large 200000 --weld 0.0001                a dirty pleated skirt of 200,000 triangles
  sweep --budgets 36 --filter '*dress*'             36 texel budgets from 1,000 to 40,000";

/// Parts that run on their own.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// One build, measured, as JSON; runs as a child of the sweep.
    #[command(hide = true)]
    One(OneArgs),
}

/// Selects the meshes and their settings.
#[derive(Debug, Args)]
pub struct SweepArgs {
    /// Folders to search for meshes, and mesh files.
    pub paths: Vec<PathBuf>,
    /// Build generated hard meshes.
    #[arg(long)]
    pub hard: bool,
    /// Build sample garments damaged on purpose.
    #[arg(long)]
    pub damaged: bool,
    /// Build a dirty pleated skirt of N triangles in 960 panels; needs `--weld 0.0001`.
    #[arg(long, value_name = "N", requires = "weld", value_parser = clap::value_parser!(u32).range(8_000..=4_000_000))]
    pub large: Option<u32>,
    /// Build each mesh at N texel budgets from 1,000 to 40,000; without a mesh, the clean garments.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=1000))]
    pub budgets: Option<u32>,
    /// Number of generated meshes; default 1,000 with --hard, 3,000 with --damaged.
    #[arg(long, value_name = "N")]
    pub count: Option<usize>,
    /// Seed of the generated meshes.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Texel budget of a build.
    #[arg(long, default_value_t = 16_384, value_name = "N", value_parser = clap::value_parser!(u32).range(9..=16_777_214))]
    pub texels: u32,
    /// Joins vertices within this distance \[m\].
    #[arg(long, value_name = "M")]
    pub weld: Option<f64>,
    /// Where texels go.
    #[arg(long, value_delimiter = ',', default_value = "fit")]
    pub sample: Vec<SampleArg>,
    /// Only meshes whose name matches: `*` stands for any characters, `?` for one.
    #[arg(long, value_name = "GLOB")]
    pub filter: Option<String>,
    /// Only every N-th mesh, from the I-th on (1 to N).
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<(usize, usize)>,
    /// Builds at a time.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub jobs: usize,
    /// Threads of a build.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub threads: usize,
    /// CPU seconds a build may take.
    #[arg(long, default_value_t = 60, value_name = "S")]
    pub limit_seconds: u64,
    /// Address space a build may take [MiB].
    #[arg(long, default_value_t = 8192, value_name = "MIB")]
    pub limit_mib: u64,
    /// Writes one row per piece to this file.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Keeps the generated meshes as OBJ files in this folder.
    #[arg(long, value_name = "DIR")]
    pub write_meshes: Option<PathBuf>,
    /// Builds nothing; with --write-meshes, only writes the meshes.
    #[arg(long)]
    pub dry_run: bool,
    /// Number of pieces in the list of the worst.
    #[arg(long, default_value_t = 20, value_name = "N")]
    pub worst: usize,
}

/// One build.
#[derive(Debug, Args)]
pub struct OneArgs {
    /// The mesh.
    pub mesh: PathBuf,
    /// Texel budget.
    #[arg(long)]
    pub texels: u32,
    /// Where texels go.
    #[arg(long)]
    pub sample: SampleArg,
    /// Joins vertices within this distance \[m\].
    #[arg(long)]
    pub weld: Option<f64>,
    /// CPU seconds the process may take.
    #[arg(long)]
    pub limit_seconds: u64,
    /// Address space the process may take [MiB].
    #[arg(long)]
    pub limit_mib: u64,
    /// Receives the measurements as JSON.
    #[arg(long)]
    pub out: PathBuf,
}

/// [`Sample`] by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SampleArg {
    /// On the surface.
    Point,
    /// By least squares.
    Fit,
}

impl SampleArg {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Fit => "fit",
        }
    }
}

impl OneArgs {
    /// The options of this build.
    pub fn options(&self) -> BuildOptions {
        let sample = match self.sample {
            SampleArg::Point => Sample::Point,
            SampleArg::Fit => Sample::Fit,
        };
        let image = PieceOptions { size: ImageSize::Texels(self.texels), sample, ..PieceOptions::default() };
        let repair = RepairOptions { weld: self.weld };
        BuildOptions { image, repair, ..BuildOptions::default() }
    }
}

/// Reads `I/N`, 1 <= I <= N.
fn shard(text: &str) -> Result<(usize, usize), String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    parsed.filter(|&(i, n)| (1..=n).contains(&i)).ok_or_else(|| "give I/N with I from 1 to N, such as 2/5".into())
}

/// Whether a name matches a pattern in which `*` stands for any characters and `?` for one.
pub fn matches(pattern: &str, name: &str) -> bool {
    let (p, n): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut i, mut j, mut star) = (0, 0, None);
    while j < n.len() {
        if i < p.len() && (p[i] == '?' || p[i] == n[j]) && p[i] != '*' {
            (i, j) = (i + 1, j + 1);
        } else if i < p.len() && p[i] == '*' {
            star = Some((i, j));
            i += 1;
        } else if let Some((si, sj)) = star {
            (i, j) = (si + 1, sj + 1);
            star = Some((si, sj + 1));
        } else {
            return false;
        }
    }
    p[i..].iter().all(|&c| c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
        let cli = Cli::parse_from(["sweep", "--hard", "--shard", "2/5"]);
        assert_eq!((cli.sweep.shard, cli.sweep.texels), (Some((2, 5)), 16_384));
        assert!(Cli::try_parse_from(["sweep", "--shard", "0/5"]).is_err());
        assert!(Cli::try_parse_from(["sweep", "--shard", "6/5"]).is_err());
    }

    #[test]
    fn patterns_match_whole_names() {
        for (pattern, name, expected) in [
            ("lace-*", "lace-03", true),
            ("*dress*", "a_dress_b", true),
            ("*a*b", "xaxbxb", true),
            ("lace", "lace-03", false),
            ("l?ce*", "lace", true),
            ("", "x", false),
            ("*", "", true),
        ] {
            assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
        }
    }
}
