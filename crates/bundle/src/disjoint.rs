//! Disjoint sets (union-find) whose representative is their smallest member.

/// Disjoint sets over the indices `0..n`. The representative of a set is its smallest member, so results do not depend on
/// the order of unions.
///
/// ```
/// let mut sets = gimage_bundle::DisjointSets::new(4);
/// assert!(sets.union(3, 1));
/// assert!(!sets.union(1, 3));
/// assert_eq!(sets.into_representatives(), [0, 1, 2, 1]);
/// ```
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// `n` sets of one member each.
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    /// The representative of the set of `x`. Amortised O(log n): paths are halved on the way.
    #[inline]
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            let up = self.0[self.0[x as usize] as usize];
            self.0[x as usize] = up;
            x = up;
        }
        x
    }

    /// Joins the sets of `a` and `b`; false if they are one set already.
    #[inline]
    pub fn union(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// The number of sets with a member `x` for which `marked[x]` is true.
    pub fn count(&mut self, marked: &[bool]) -> usize {
        let mut seen = vec![false; self.0.len()];
        let mut is_new = |root: u32| !std::mem::replace(&mut seen[root as usize], true);
        (0..marked.len() as u32).filter(|&x| marked[x as usize] && is_new(self.find(x))).count()
    }

    /// The representative of every index.
    pub fn into_representatives(mut self) -> Vec<u32> {
        (0..self.0.len() as u32).map(|x| self.find(x)).collect()
    }
}
