//! The result of one build, as the child writes it and the tables read it.

use serde::{Deserialize, Serialize};

/// The end of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Status {
    /// There is a bundle.
    Built,
    /// The build returned an error.
    Refused {
        /// A short name of the kind of error, such as `piece: parameterize`.
        kind: String,
        /// Its message.
        message: String,
    },
    /// The process panicked.
    Panicked(String),
    /// The process ran out of time.
    TimedOut,
    /// The process ended otherwise: out of memory, a stack overflow.
    #[default]
    Died,
}

/// One finding of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Finding {
    /// `note`, `repair`, `warning` or `error`.
    pub severity: String,
    /// The stage by name.
    pub stage: String,
    /// The kind by name.
    pub kind: String,
    /// How often.
    pub count: u64,
    /// A few places.
    pub examples: Vec<String>,
    /// One sentence.
    pub message: String,
}

/// Measurements that do not depend on those of the build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// By how much texels lie outside the box of the source / diagonal of the source.
    pub outside: f64,
    /// Root mean square distance from the source to the image / diagonal; `None` where the two cannot be matched.
    pub rms_out: Option<f64>,
    /// The same from the image to the source.
    pub rms_back: Option<f64>,
    /// Largest distance of the samples, either way / diagonal.
    pub hausdorff: Option<f64>,
}

/// One rung of the ladder that a build climbed for a piece.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Rung {
    /// Its name.
    pub rung: String,
    /// PSNR of the image it made \[dB\].
    pub psnr: Option<f64>,
    /// Whether this image was kept.
    pub kept: bool,
}

/// One piece of a bundle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Its name.
    pub name: String,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Triangles of the source.
    pub triangles: u32,
    /// Euler number of the source.
    pub euler: i32,
    /// Boundary loops of the source.
    pub loops: u32,
    /// PSNR by the build's own measure \[dB\].
    pub psnr: Option<f64>,
    /// Largest distance by the build's own measure / diagonal.
    pub hausdorff: Option<f64>,
    /// L2 stretch of the map.
    pub l2: Option<f64>,
    /// Largest stretch of the map.
    pub stretch: Option<f64>,
    /// Mean symmetric Dirichlet energy of the map.
    pub energy: Option<f64>,
    /// Mean angle between normals \[degrees\].
    pub normal: Option<f64>,
    /// Share of the image that faces the wrong way.
    pub fold: Option<f64>,
    /// Triangles that the map turns over.
    pub flips: Option<u64>,
    /// Rungs of the ladder in the order they were tried; empty where the first one was enough.
    pub rungs: Vec<Rung>,
    /// Measured independently.
    pub probe: Probe,
}

impl Piece {
    /// PSNR by the independent measure, the worse of the two directions \[dB\].
    pub fn probe_psnr(&self) -> Option<f64> {
        let rms = match (self.probe.rms_out, self.probe.rms_back) {
            (Some(a), Some(b)) => a.max(b),
            (a, b) => a.or(b)?,
        };
        // A distance of 0 would be infinitely good; f32 ends at about 140 dB.
        Some(-20.0 * rms.max(1e-9).log10())
    }

    /// The worse of the two measures of PSNR \[dB\].
    pub fn worst_psnr(&self) -> Option<f64> {
        match (self.psnr, self.probe_psnr()) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    /// The larger of the two measures of the largest distance / diagonal.
    pub fn worst_hausdorff(&self) -> Option<f64> {
        match (self.hausdorff, self.probe.hausdorff) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        }
    }
}

/// All of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Record {
    /// Its mesh by name.
    pub mesh: String,
    /// Texel budget.
    pub texels: u32,
    /// Where texels went.
    pub sample: String,
    /// The end.
    pub status: Status,
    /// Triangles of the file.
    pub triangles: usize,
    /// Pieces.
    pub pieces: Vec<Piece>,
    /// Accessories, and the largest of them as a share of the area.
    pub accessories: usize,
    /// See `accessories`.
    pub largest_accessory: f64,
    /// Findings.
    pub findings: Vec<Finding>,
    /// CPU seconds of the build.
    pub cpu: f64,
    /// Wall seconds of the build.
    pub wall: f64,
    /// Largest memory \[MiB\].
    pub mib: f64,
}
