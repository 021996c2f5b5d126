//! The joints that a point follows.

use std::collections::BTreeMap;

/// The strongest of some joints whose weights are above 0, strongest first and at most `most` of them, with weights that sum to 1.
pub(crate) fn strongest(weights: BTreeMap<u32, f64>, most: usize) -> Vec<(u32, f64)> {
    let mut list: Vec<(u32, f64)> = weights.into_iter().filter(|x| x.1 > 0.0).collect();
    list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    list.truncate(most);
    let total: f64 = list.iter().map(|x| x.1).sum();
    list.iter_mut().for_each(|x| x.1 /= total);
    list
}
