//! Steps in which cloth bends as stiffly as its material says.

use crate::cloth::Cloth;

/// Share of the particles that bend as stiffly as they should.
const SHARE: f64 = 0.9;

/// The longest such step \[s\]; infinite for cloth that does not resist to bending. In longer steps the multipliers of bending
/// are bounded (`moments`), and cloth bends more easily, by the square of the ratio.
pub fn longest(cloth: &Cloth) -> f64 {
    let Some(bending) = cloth.bending() else { return f64::INFINITY };
    let bounds = bending.bounds(cloth);
    let each = bending.compliance.iter().zip(bounds).filter(|(soft, bound)| **soft > 0.0 && *bound > 0.0);
    let mut spans: Vec<f64> = each.map(|(soft, bound)| f64::from(*soft) / f64::from(bound)).collect();
    spans.sort_by(f64::total_cmp);
    let least = ((1.0 - SHARE) * spans.len() as f64) as usize;
    spans.get(least).map_or(f64::INFINITY, |span| span.sqrt())
}
