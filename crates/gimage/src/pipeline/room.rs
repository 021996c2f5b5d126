//! Whether the images of a build fit into a bundle, and into memory. It is asked before any image is made.

use crate::base::memory::available;
use crate::error::{Error, Result};

/// Bytes per texel that a build takes at its peak, measured on garments of 1 to 16 million texels. Most of it is the tree
/// of the image's triangles that distances are measured with.
const BYTES_PER_TEXEL: f64 = 1500.0;

/// Errors on more texels than a bundle can have, or than the memory of this machine is enough for; `hint` says how to ask for
/// fewer.
pub(super) fn fits(texels: f64, what: impl Fn() -> String, hint: &str) -> Result<()> {
    fits_into(texels, available(), what, hint)
}

/// As [`fits`], into `memory` \[bytes\] if that is known.
fn fits_into(texels: f64, memory: Option<u64>, what: impl Fn() -> String, hint: &str) -> Result<()> {
    let refused = |need: String, limit: String| Err(Error::TooLarge { what: what(), need, limit, hint: hint.into() });
    let limit = gimage_bundle::MAX_PARTICLES;
    if texels > f64::from(limit) {
        return refused(format!("{texels:.0} texels"), format!("{limit} texels"));
    }
    match memory.map(|bytes| bytes as f64) {
        Some(limit) if texels * BYTES_PER_TEXEL > limit => {
            let gigabytes = |bytes: f64| format!("{:.1} GB of memory", bytes / 1e9);
            refused(gigabytes(texels * BYTES_PER_TEXEL), gigabytes(limit))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(texels: f64, memory: Option<u64>) -> Option<String> {
        fits_into(texels, memory, || "2 images".into(), "give fewer texels").err().map(|e| e.to_string())
    }

    #[test]
    fn images_that_memory_is_too_small_for_are_refused_and_the_numbers_named() {
        let large = 4000.0 * 4000.0;
        assert_eq!(
            said(large, Some(8_000_000_000)).unwrap(),
            "2 images: needs 24.0 GB of memory, at most 8.0 GB of memory allowed; give fewer texels"
        );
        assert_eq!(said(large, Some(25_000_000_000)), None);
        assert_eq!(said(large, None), None);
    }

    #[test]
    fn images_that_a_bundle_cannot_hold_are_refused_whatever_the_memory() {
        for memory in [None, Some(u64::MAX)] {
            assert!(said(f64::from(gimage_bundle::MAX_PARTICLES) + 1.0, memory).unwrap().contains("16777215 texels"));
        }
    }
}
