//! Points that drags hold, which several may do at once.

/// The points of a cloth that drags hold: each with the number of drags, and whether it was pinned before the first of them.
#[derive(Clone, Debug, Default)]
pub struct Grabs(Vec<(u32, u32, bool)>);

impl Grabs {
    /// Takes in a drag that holds a point, which was pinned or not.
    pub fn grab(&mut self, point: u32, pinned: bool) {
        match self.0.iter_mut().find(|held| held.0 == point) {
            Some(held) => held.1 += 1,
            None => self.0.push((point, 1, pinned)),
        }
    }

    /// Takes a drag off; whether the point stays where it is. Of a point that is not known here, `pinned` tells whether it was pinned before.
    pub fn release(&mut self, point: u32, pinned: bool) -> bool {
        let Some(at) = self.0.iter().position(|held| held.0 == point) else { return pinned };
        self.0[at].1 -= 1;
        let (_, drags, pinned) = self.0[at];
        if drags == 0 {
            self.0.remove(at);
        }
        drags > 0 || pinned
    }
}
