//! Where the corners of a disk's triangles lie on the surface's: most are whole triangles of it, which take one number each.

/// Barycentric coordinates of three corners in a triangle of the surface.
pub type Corner3 = [[f64; 3]; 3];

/// A triangle of the surface, as it is and turned over.
const WHOLE: [Corner3; 2] =
    [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]];

/// For each triangle of a disk, the barycentric coordinates of its corners in the surface triangle it lies in.
#[derive(Clone, Debug, Default)]
pub struct Corners {
    /// Which of [`WHOLE`], or 2 and more: which of the parts.
    which: Vec<u32>,
    parts: Vec<Corner3>,
}

impl Corners {
    /// Of `n` whole triangles.
    pub(crate) fn whole(n: usize) -> Self {
        Self { which: vec![0; n], parts: Vec::new() }
    }

    /// Of triangle `t`.
    pub fn of(&self, t: usize) -> Corner3 {
        let k = self.which[t] as usize;
        WHOLE.get(k).copied().unwrap_or_else(|| self.parts[k - WHOLE.len()])
    }

    /// Turns a whole triangle over.
    pub(crate) fn turn(&mut self, t: usize) {
        self.which[t] = 1;
    }

    /// Splits triangle `t` in two: one stays in its place, the other is added.
    pub(crate) fn split(&mut self, t: usize, stays: Corner3, added: Corner3) {
        match self.which[t] as usize {
            k if k < WHOLE.len() => self.which[t] = self.add(stays),
            k => self.parts[k - WHOLE.len()] = stays,
        }
        let added = self.add(added);
        self.which.push(added);
    }

    fn add(&mut self, part: Corner3) -> u32 {
        self.parts.push(part);
        (WHOLE.len() + self.parts.len() - 1) as u32
    }

    /// Room for triangles to be added.
    pub(crate) fn reserve(&mut self, triangles: usize) {
        self.which.reserve_exact(triangles);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_split_in_its_place_and_whole_triangles_stay_whole() {
        let mut c = Corners::whole(3);
        c.turn(1);
        let part = |x: f64| [[x; 3]; 3];
        c.split(1, part(0.1), part(0.2));
        c.split(1, part(0.3), part(0.4));
        c.split(3, part(0.5), part(0.6));
        let expected = [WHOLE[0], part(0.3), WHOLE[0], part(0.5), part(0.4), part(0.6)];
        assert_eq!((0..6).map(|t| c.of(t)).collect::<Vec<_>>(), expected);
        assert_eq!(c.parts.len(), 4);
    }
}
