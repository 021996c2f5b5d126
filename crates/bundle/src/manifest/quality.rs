//! The quality figures in the manifest.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Quality measured, of a piece or of the bundle. Figures that were not measured are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// 20 log10(diagonal / rms) \[dB\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Larger of the two one-sided root-mean-square distances \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// `rms` / `diagonal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_rel: Option<f64>,
    /// Largest distance either way \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hausdorff: Option<f64>,
    /// `hausdorff` / `diagonal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hausdorff_rel: Option<f64>,
    /// Diagonal of the source's bounding box \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagonal: Option<f64>,
    /// Mean angle between normals of source and reconstruction \[degrees\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_degrees: Option<f64>,
    /// L2 stretch of the map (1 = isometric).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch_l2: Option<f64>,
    /// Largest stretch of the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch_max: Option<f64>,
    /// Mean symmetric Dirichlet energy at its best scale (4 = isometric).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub symmetric_dirichlet: Option<f64>,
    /// Source triangles that the map turns over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flips: Option<u64>,
    /// Share of the reconstructed area that faces the wrong way, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fold_area: Option<f64>,
    /// Largest distance between duplicates \[m\]; 0 in a sound bundle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seam_gap: Option<f64>,
    /// Ratio of the longest to the shortest rest length of springs of one kind, averaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spring_anisotropy: Option<f64>,
    /// Any further measure, by name.
    #[serde(flatten)]
    pub more: BTreeMap<String, Value>,
}

impl Quality {
    /// Whether no figure was measured.
    pub fn is_empty(&self) -> bool {
        *self == Quality::default()
    }
}
