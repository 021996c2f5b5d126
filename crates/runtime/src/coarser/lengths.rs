//! Rest lengths of a coarser image, measured along the springs of the image that it is made of.

use crate::cloth::{Cloth, Compliance, Grid, Rest, other_end};
use crate::number::real::{dot, sub};

/// The springs of a grid.
pub struct Springs<'a> {
    pub cloth: &'a Cloth,
    pub grid: usize,
}

impl Springs<'_> {
    /// Length \[m\] of a spring by the texel that stores it; `None` where there is no spring.
    fn of(&self, x: i64, y: i64, d: usize) -> Option<f64> {
        let grid = &self.cloth.grids()[self.grid];
        let (w, h) = (i64::from(grid.width), i64::from(grid.height));
        let inside = (0..w).contains(&x) && (0..h).contains(&y);
        let length = if inside { self.cloth.spring(self.grid, (y * w + x) as usize, d) } else { 0.0 };
        (length > 0.0).then_some(f64::from(length))
    }

    /// Length of a step to one of the eight neighbours.
    fn step(&self, x: i64, y: i64, (dx, dy): (i64, i64)) -> Option<f64> {
        match (dx, dy) {
            (1, 0) => self.of(x, y, 0),
            (-1, 0) => self.of(x - 1, y, 0),
            (0, 1) => self.of(x, y, 1),
            (0, -1) => self.of(x, y - 1, 1),
            (1, 1) => self.of(x, y, 2),
            (-1, -1) => self.of(x - 1, y - 1, 2),
            (1, -1) => self.of(x, y, 3),
            (-1, 1) => self.of(x - 1, y + 1, 3),
            _ => None,
        }
    }

    /// Length \[m\] from one texel to another nearby at rest; 0 where no springs lead there. Along rows, columns and diagonals the sum of
    /// the springs; else a straight line in the plane of the cells between the two, at most the way along springs.
    pub fn between(&self, a: [u32; 2], b: [u32; 2]) -> f32 {
        let [x, y] = a.map(i64::from);
        let (dx, dy) = (i64::from(b[0]) - x, i64::from(b[1]) - y);
        let Some([path, start]) = self.path(x, y, dx, dy) else { return 0.0 };
        let straight = dx == 0 || dy == 0 || dx.abs() == dy.abs();
        let line = if straight { None } else { self.line(x, y, dx, dy) };
        // No shorter than straight through space, as springs are at rest: else ways along the surface, and tethers, come out too short.
        let least = if start > 0.0 { self.apart([x, y], [x + dx, y + dy]) * (path / start) } else { path };
        line.map_or(path, |line| line.max(least).min(path)) as f32
    }

    /// Distance \[m\] of two texels at the start.
    fn apart(&self, a: [i64; 2], b: [i64; 2]) -> f64 {
        let grid = &self.cloth.grids()[self.grid];
        let place = |[x, y]: [i64; 2]| {
            let k = grid.first as usize + (y * i64::from(grid.width) + x) as usize;
            self.cloth.positions()[k].map(f64::from)
        };
        let way = sub(place(a), place(b));
        dot(way, way).sqrt()
    }

    /// The shortest way by springs that turns back in neither direction: its length \[m\] at rest, and at the start.
    fn path(&self, x: i64, y: i64, dx: i64, dy: i64) -> Option<[f64; 2]> {
        let (right, down) = (dx.signum(), dy.signum());
        let columns = dx.unsigned_abs() as usize + 1;
        let mut far: Vec<Option<[f64; 2]>> = Vec::new();
        for n in 0..columns * (dy.unsigned_abs() as usize + 1) {
            let (i, j) = (n % columns, n / columns);
            let at = (x + right * i as i64, y + down * j as i64);
            let from = [(i > 0, j > 0, 1 + columns), (i > 0, true, 1), (true, j > 0, columns)];
            let ways = from.iter().zip([(right, down), (right, 0), (0, down)]).filter_map(|((a, b, back), step)| {
                let before = far.get(n.checked_sub(*back).filter(|_| *a && *b)?).copied().flatten()?;
                let (from, to) = ([at.0 - step.0, at.1 - step.1], [at.0, at.1]);
                let [rest, start]: [f64; 2] = before;
                Some([rest + self.step(from[0], from[1], step)?, start + self.apart(from, to)])
            });
            let best = ways.min_by(|a, b| a[0].total_cmp(&b[0]));
            far.push(if n == 0 { Some([0.0; 2]) } else { best });
        }
        far.last().copied().flatten()
    }

    /// The straight line, by the mean of the cells between the two: along a row a, along a column b, their product c.
    fn line(&self, x: i64, y: i64, dx: i64, dy: i64) -> Option<f64> {
        let (left, right) = (x.min(x + dx), x.max(x + dx));
        let (above, below) = (y.min(y + dy), y.max(y + dy));
        let mean = |columns: i64, rows: i64, of: &dyn Fn(i64, i64) -> Option<f64>| {
            let all = (above..=below - rows).flat_map(|j| (left..=right - columns).map(move |i| (i, j)));
            let (sum, count) = all.filter_map(|(i, j)| of(i, j)).fold((0.0, 0u32), |(s, n), x| (s + x, n + 1));
            (count > 0).then(|| sum / f64::from(count))
        };
        let a = mean(1, 0, &|i, j| Some(self.of(i, j, 0)?.powi(2)))?;
        let b = mean(0, 1, &|i, j| Some(self.of(i, j, 1)?.powi(2)))?;
        let c = mean(1, 1, &|i, j| Some((self.of(i, j, 2)?.powi(2) - self.of(i, j + 1, 3)?.powi(2)) / 4.0))?;
        let (dx, dy) = (dx as f64, dy as f64);
        let square = dx * dx * a + 2.0 * dx * dy * c + dy * dy * b;
        (square > 0.0).then(|| square.sqrt())
    }
}

/// Rest lengths of coarse grids whose texels lie at some texels of a cloth; the same for a whole grid where they are. `there` tells which
/// coarse particles exist, `points` the first duplicate of the fine particle of each. Duplicates have no spring between them.
pub fn rest(cloth: &Cloth, grids: &[Grid], (at, points): (&[[u32; 2]], &[u32]), there: impl Fn(usize) -> bool) -> Rest {
    if matches!(cloth.rest(), Rest::None) {
        return Rest::None;
    }
    let directions = cloth.directions();
    let mut image = vec![[0.0; 4]; at.len()];
    let mut constant = vec![[0.0; 4]; grids.len()];
    let mut is_constant = true;
    for (g, grid) in grids.iter().enumerate() {
        let springs = Springs { cloth, grid: g };
        let first = grid.first as usize;
        let mut seen = [false; 4];
        for (local, d) in (0..grid.texels()).flat_map(|k| (0..4).map(move |d| (k, d))) {
            let Some(other) = other_end(grid.width as usize, grid.height as usize, local, d) else { continue };
            let joined = points[first + local] == points[first + other];
            is_constant &= !joined;
            if joined || !(directions[d] && there(first + local) && there(first + other)) {
                continue;
            }
            let length = springs.between(at[first + local], at[first + other]);
            image[first + local][d] = length;
            let known = std::mem::replace(&mut seen[d], true);
            is_constant &= !known || length == constant[g][d];
            constant[g][d] = length;
        }
    }
    if is_constant { Rest::Constant(constant) } else { Rest::Image(image) }
}

/// The compliance of coarse springs: that of the springs that they follow. Two in a row yield twice as much as one, and two side by side
/// half as much.
pub fn compliance(cloth: &Cloth, samples: &[u32]) -> Compliance {
    let Compliance::Image(soft) = &cloth.compliance else { return cloth.compliance.clone() };
    Compliance::Image(samples.iter().map(|k| soft[*k as usize]).collect())
}
