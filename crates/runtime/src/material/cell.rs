//! Cells of a grid, laid out in the plane by their rest lengths.

use crate::cloth::Cloth;

/// A point of the plane \[m\].
pub type P2 = [f64; 2];

/// The four texels (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1) and the springs between them.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Index of each corner among the particles of the cloth.
    pub corners: [usize; 4],
    /// Which of them the cell has: all, or three.
    pub there: [bool; 4],
    /// Where they lie \[m\]; the plane is seen from the side from which rows run down.
    pub at: [P2; 4],
}

/// Corners joined by each spring, the corner that stores it, and its direction.
pub const SPRINGS: [(usize, usize, usize, usize); 6] =
    [(0, 1, 0, 0), (2, 3, 2, 0), (0, 2, 0, 1), (1, 3, 1, 1), (0, 3, 0, 2), (2, 1, 2, 3)];

impl Cell {
    /// The springs of the cell: corners, index of the texel that stores it, direction.
    pub fn springs(&self) -> impl Iterator<Item = ([usize; 2], usize, usize)> + '_ {
        let there = |s: &&(usize, usize, usize, usize)| self.there[s.0] && self.there[s.1];
        SPRINGS.iter().filter(there).map(|s| ([s.0, s.1], self.corners[s.2], s.3))
    }

    /// Its corners in a circle.
    pub fn around(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        [0, 1, 3, 2].into_iter().filter(|k| self.there[*k])
    }

    /// The rotation (cosine, sine) that turns the plane's axes so that the first one is nearest to the rows of the grid
    /// and the second one to its columns.
    pub fn axes(&self) -> P2 {
        let (right, down) = self.sides();
        let turn = [right[0] + down[1], right[1] - down[0]];
        let size = turn[0].hypot(turn[1]);
        if size > 0.0 { [turn[0] / size, turn[1] / size] } else { [1.0, 0.0] }
    }

    /// How the cell lies for a step right and one down.
    fn sides(&self) -> (P2, P2) {
        let mut sums = [[0.0; 2]; 2];
        for ([a, b], _, direction) in self.springs().filter(|s| s.2 < 2) {
            let step = sub(self.at[b], self.at[a]);
            (0..2).for_each(|c| sums[direction][c] += step[c]);
        }
        (sums[0], sums[1])
    }
}

/// The cells of a grid that have an area.
pub fn cells<'a>(cloth: &'a Cloth, index: usize, same: &'a [u32]) -> impl Iterator<Item = Cell> + 'a {
    let grid = &cloth.grids()[index];
    let (first, w, h) = (grid.first as usize, grid.width as usize, grid.height as usize);
    let upper_left = (0..h - 1).flat_map(move |j| (0..w - 1).map(move |i| j * w + i));
    upper_left.filter_map(move |k| {
        let local = [k, k + 1, k + w, k + w + 1];
        let corners = local.map(|k| first + k);
        let lengths = SPRINGS.map(|s| f64::from(cloth.spring(index, local[s.2], s.3)));
        let mut there = corners.map(|k| cloth.particles()[k].exists());
        // Two corners that are one point are one corner; a point across does not make a cell.
        for s in &SPRINGS[..4] {
            if there[s.0] && there[s.1] && same[corners[s.0]] == same[corners[s.1]] {
                there[s.1] = false;
            }
        }
        let at = lay(there, lengths)?;
        Some(Cell { corners, there, at })
    })
}

/// Least area of a cell against the square of its longest spring.
const FLAT: f64 = 1e-4;

/// Where the corners lie; none for a cell that lacks corners, springs or an area.
fn lay(there: [bool; 4], lengths: [f64; 6]) -> Option<[P2; 4]> {
    let known = SPRINGS.iter().zip(lengths).all(|(s, l)| !(there[s.0] && there[s.1]) || l > 0.0);
    match there.iter().filter(|t| **t).count() {
        4 if known => quad(lengths),
        3 if known => triangle(there, lengths),
        _ => None,
    }
}

/// Six lengths of four corners are one too many for a plane: the corners are taken as a tetrahedron and seen along the
/// normal of its diagonals, so that no length is preferred to its opposite.
fn quad([top, bottom, left, right, down, up]: [f64; 6]) -> Option<[P2; 4]> {
    let [t2, b2, l2, r2] = [top, bottom, left, right].map(|x| x * x);
    // Products of the diagonals with one another and with what their middles lie apart.
    let across = 0.5 * (b2 + t2 - l2 - r2);
    let (on_down, on_up) = (0.25 * (r2 + b2 - t2 - l2), 0.25 * (b2 + l2 - t2 - r2));
    let along = across / down;
    let rise = (up * up - along * along).max(0.0).sqrt();
    if down * rise < FLAT * down.max(up).powi(2) {
        return None;
    }
    let (d1, d2) = ([down, 0.0], [along, -rise]);
    let apart = [on_down / down, (on_up - along * on_down / down) / -rise];
    let corner = |sign: f64, d: P2, s: f64| [0, 1].map(|c| 0.5 * (sign * apart[c] + s * d[c]));
    Some([corner(1.0, d1, -1.0), corner(-1.0, d2, 1.0), corner(-1.0, d2, -1.0), corner(1.0, d1, 1.0)])
}

fn triangle(there: [bool; 4], lengths: [f64; 6]) -> Option<[P2; 4]> {
    let k: Vec<usize> = (0..4).filter(|k| there[*k]).collect();
    let length = |a: usize, b: usize| {
        let of = SPRINGS.iter().position(|s| (s.0, s.1) == (a, b) || (s.1, s.0) == (a, b));
        of.map(|n| lengths[n])
    };
    let (pq, pr, qr) = (length(k[0], k[1])?, length(k[0], k[2])?, length(k[1], k[2])?);
    let x = (pq * pq + pr * pr - qr * qr) / (2.0 * pq);
    let y = (pr * pr - x * x).max(0.0).sqrt();
    if pq * y < FLAT * pq.max(pr).powi(2) {
        return None;
    }
    // The side that the third corner is on in the grid.
    let grid = |k: usize| [(k & 1) as f64, (k >> 1) as f64];
    let side = cross(sub(grid(k[1]), grid(k[0])), sub(grid(k[2]), grid(k[0])));
    let mut at = [[0.0; 2]; 4];
    (at[k[1]], at[k[2]]) = ([pq, 0.0], [x, y * side.signum()]);
    Some(at)
}

pub fn sub(a: P2, b: P2) -> P2 {
    [a[0] - b[0], a[1] - b[1]]
}

pub fn cross(a: P2, b: P2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
