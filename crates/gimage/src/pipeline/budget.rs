//! Shares the texels of a bundle out among its pieces, and keeps to their number.
//!
//! A grid has at least [`LEAST_GRID`] texels; a component that would get fewer than [`LEAST_SHARE`] is an accessory,
//! unless it has a tenth of the area ([`ALWAYS_PIECE`]). An image can come out larger than asked where its border needs
//! more room; the other pieces then give up texels ([`again`]).

use crate::record::{Finding, Severity};
use crate::stage::component::ALWAYS_PIECE;

/// Texels below which the image of a small component is not worth having: 8 x 8.
pub(crate) const LEAST_SHARE: u32 = 64;

/// Texels of the smallest image, 3 x 3.
const LEAST_GRID: u32 = 9;

/// How often images are made again to keep the number of texels.
pub(crate) const ROUNDS: usize = 4;

/// The texels of each component, or `None` where it becomes an accessory as its share is too small.
///
/// `areas` are in descending order. Accessories leave their texels to the others. The sum is at most `texels`, unless
/// components of a tenth of the area or more get less than the smallest grid otherwise. O(components).
pub(crate) fn share_out(areas: &[f64], texels: u32) -> Vec<Option<u32>> {
    let all: f64 = areas.iter().sum();
    let share = |area: f64, of: f64| (f64::from(texels) * (area / of)).floor() as u32;
    let (mut kept, mut sum) = (areas.len(), all);
    // The smallest go first: each that goes makes the shares of the others larger.
    while kept > 1 && areas[kept - 1] < ALWAYS_PIECE * all && share(areas[kept - 1], sum) < LEAST_SHARE {
        kept -= 1;
        sum = areas[..kept].iter().sum();
    }
    (0..areas.len()).map(|k| (k < kept).then(|| share(areas[k], sum).max(LEAST_GRID))).collect()
}

/// The size of one piece's image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Made {
    /// Texels asked for.
    pub asked: u32,
    /// Texels that came out.
    pub texels: u32,
    /// Least texels it may be asked for.
    pub least: u32,
    /// Least texels that it is left with for the borders of others.
    pub kept: u32,
    /// It does not get smaller when asked for less: its border needs the room.
    pub bound: bool,
    /// How often it was made again and got no smaller.
    misses: u32,
}

/// Asking for less may miss once, where the next smaller image does not weld.
const MISSES: u32 = 2;

/// A piece gives up texels to the borders of others until it has this share of its own: 40 % as many across.
const LEAST_KEPT: f64 = 0.15;

/// An image this many times as large as asked for is larger for its border, and not for rounding.
const OVER: f64 = 1.25;

/// An image this many times as large as asked for is made again, asked for half, before others give up texels for it.
const GROSS: f64 = 8.0;
const HALF: f64 = 0.5;

impl Made {
    /// A first image of a piece that has `share` of the area of all.
    pub(crate) fn new(asked: u32, texels: u32, share: f64) -> Self {
        let least = if share < ALWAYS_PIECE { LEAST_SHARE } else { LEAST_GRID };
        Self {
            asked,
            texels,
            least,
            kept: ((LEAST_KEPT * f64::from(asked)).ceil() as u32).max(least),
            bound: false,
            misses: 0,
        }
    }

    /// The piece was asked for `asked` texels and came out with `texels`; `None` if it did not come out. Whether the new
    /// image is the one to keep.
    pub(crate) fn made_again(&mut self, asked: u32, texels: Option<u32>) -> bool {
        self.asked = asked;
        let smaller = texels.filter(|&t| t < self.texels);
        self.misses += u32::from(smaller.is_none());
        self.bound = self.misses >= MISSES;
        self.texels = smaller.unwrap_or(self.texels);
        smaller.is_some()
    }
}

/// Which pieces to make again, with how many texels, so that all together have at most `texels`; empty if they have, or if
/// nothing is left to give. Pieces share the loss in proportion, but for those that their borders bind; while some are
/// grossly larger than asked for, only these are made again.
pub(crate) fn again(made: &[Made], texels: u32) -> Vec<(usize, u32)> {
    let sum = |bound: bool| made.iter().filter(|m| m.bound == bound).map(|m| u64::from(m.texels)).sum::<u64>();
    let (bound, free) = (sum(true), sum(false));
    if bound + free <= u64::from(texels) {
        return Vec::new();
    }
    let left = u64::from(texels).saturating_sub(bound) as f64 / free.max(1) as f64;
    let over = |m: &Made, by: f64| f64::from(m.texels) > by * f64::from(m.asked);
    let any = |gross: bool| made.iter().any(|m| !m.bound && over(m, GROSS) == gross);
    let gross = any(true) && any(false);
    let least = |m: &Made| if over(m, OVER) { m.least } else { m.kept };
    let left = if gross { left.max(HALF) } else { left };
    made.iter()
        .enumerate()
        .filter(|(_, m)| !m.bound && (!gross || over(m, GROSS)))
        .map(|(k, m)| (k, ((f64::from(m.asked.min(m.texels)) * left).floor() as u32).max(least(m))))
        .filter(|&(k, asked)| asked < made[k].asked)
        .collect()
}

/// A warning where the images have more texels than asked for.
pub(crate) fn exceeded(made: &[Made], names: &[&str], texels: u32) -> Option<Finding> {
    let total: u64 = made.iter().map(|m| u64::from(m.texels)).sum();
    if total <= u64::from(texels) {
        return None;
    }
    let mut over: Vec<usize> = (0..made.len()).filter(|&k| made[k].texels > made[k].asked).collect();
    over.sort_by_key(|&k| (std::cmp::Reverse(made[k].texels), k));
    let words = |&k: &usize| format!("piece {}: {} texels", names[k], made[k].texels);
    Some(Finding {
        severity: Severity::Warning,
        stage: "image",
        kind: "texel-budget",
        count: over.len() as u64,
        examples: over.iter().take(crate::record::MAX_EXAMPLES).map(words).collect(),
        message: format!(
            "The images have {total} texels, {texels} were asked for: the borders of the pieces named need that many. Give \
             --texels {total} or more, or close holes and seams with --weld METRES."
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sum(shares: &[Option<u32>]) -> u64 {
        shares.iter().flatten().map(|&t| u64::from(t)).sum()
    }

    #[test]
    fn small_parts_leave_their_texels_to_the_others() {
        let shares = share_out(&[50.0, 49.0, 1.0], 1000);
        assert_eq!(shares, [Some(505), Some(494), None]);
        // A tenth of the area is never an accessory, however few its texels.
        assert_eq!(share_out(&[9.0, 1.0], 100), [Some(90), Some(10)]);
        assert_eq!(share_out(&[9.0, 0.9], 100), [Some(100), None]);
        assert_eq!(share_out(&[1.0], 9), [Some(9)]);
        assert!(share_out(&[], 9).is_empty());
    }

    #[test]
    fn thousands_of_pieces_keep_the_budget() {
        for n in [100, 300, 1000, 5000] {
            let shares = share_out(&vec![1.0; n], 16_384);
            assert!(sum(&shares) <= 16_384);
            assert_eq!(shares.iter().flatten().count(), n.min(256), "{n}");
        }
    }

    #[test]
    fn a_piece_that_its_border_binds_takes_from_the_others() {
        let mut made = [Made::new(500, 900, 0.5), Made::new(300, 299, 0.3), Made::new(200, 196, 0.2)];
        // All shrink at first; then the first turns out to be bound, and the others give what is left.
        let asks = again(&made, 1000);
        assert_eq!(asks.len(), 3);
        for (k, asked) in asks {
            assert_eq!(made[k].made_again(asked, Some(if k == 0 { 900 } else { asked })), k > 0);
        }
        for (k, asked) in again(&made, 1000) {
            made[k].made_again(asked, Some(if k == 0 { 900 } else { asked }));
        }
        for (k, asked) in again(&made, 1000) {
            assert!(k > 0 && made[0].bound);
            made[k].made_again(asked, Some(asked));
        }
        assert!(made.iter().map(|m| m.texels).sum::<u32>() <= 1000 && again(&made, 1000).is_empty());
        assert!(exceeded(&made, &["a", "b", "c"], 1000).is_none());
    }

    #[test]
    fn a_border_of_many_texels_does_not_starve_the_other_pieces() {
        // The border of the first needs 100 times its share: it is asked again, alone, and then the others keep a part of theirs.
        let mut made = [Made::new(6000, 600_000, 0.6), Made::new(4000, 3990, 0.4)];
        for _ in 0..2 {
            let asks = again(&made, 10_000);
            assert!(asks.len() == 1 && asks[0].0 == 0, "{asks:?}");
            made[0].made_again(asks[0].1, Some(600_000));
        }
        assert!(made[0].bound);
        assert_eq!(again(&made, 10_000), [(1, 600)], "two attempts bind the first");
        made[1].made_again(600, Some(598));
        assert!(again(&made, 10_000).is_empty());
        assert!(exceeded(&made, &["net", "panel"], 10_000).is_some());
        // One that comes out well the second time takes nothing from the others.
        let mut made = [Made::new(6000, 60_000, 0.6), Made::new(4000, 3990, 0.4)];
        let asked = again(&made, 10_000)[0].1;
        made[0].made_again(asked, Some(5900));
        assert!(again(&made, 10_000).is_empty());
    }

    #[test]
    fn a_budget_that_cannot_be_kept_is_reported() {
        let mut made = [Made::new(100, 400, 1.0)];
        assert_eq!(again(&made, 100), [(0, 25)]);
        made[0].made_again(25, Some(400));
        assert_eq!(again(&made, 100), [(0, 9)]);
        made[0].made_again(9, None);
        assert!(again(&made, 100).is_empty());
        let finding = exceeded(&made, &["dress"], 100).unwrap();
        assert_eq!((finding.severity, finding.kind, finding.count), (Severity::Warning, "texel-budget", 1));
        assert!(finding.message.contains("--texels 400") && finding.examples[0].contains("dress"), "{finding:?}");
    }

    proptest! {
        #[test]
        fn shares_fit_and_large_parts_have_one(
            mut areas in prop::collection::vec(1e-6..1.0f64, 1..400), texels in 100u32..40_000
        ) {
            areas.sort_by(|a, b| b.total_cmp(a));
            let shares = share_out(&areas, texels);
            prop_assert!(sum(&shares) <= u64::from(texels));
            let all: f64 = areas.iter().sum();
            for (area, share) in areas.iter().zip(&shares) {
                prop_assert!(*area < ALWAYS_PIECE * all || share.is_some());
                prop_assert!(share.is_none_or(|s| s >= LEAST_SHARE || *area >= ALWAYS_PIECE * all));
            }
        }
    }
}
