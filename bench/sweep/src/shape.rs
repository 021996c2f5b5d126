//! A generated mesh, and the grids most of them are made from.

use std::f64::consts::TAU;
use std::fmt::Write;

/// Marks a vertex without a number.
const NONE: u32 = u32::MAX;

/// Positions \[m\] and triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Vertices \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

/// How the last column of a grid meets the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// Not at all.
    Open,
    /// They are the same vertices.
    Closed,
    /// They are the same vertices, in the opposite order.
    Twisted,
}

impl Shape {
    /// A grid of `w` x `h` quads of `f(u, v)`, u and v in 0..=1.
    pub fn sheet(w: usize, h: usize, f: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        Self::grid(w, h, Wrap::Open, Wrap::Open, |_, _| true, f)
    }

    /// The same without the quads that `keep` drops.
    pub fn masked(w: usize, h: usize, keep: impl Fn(usize, usize) -> bool, f: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        Self::grid(w, h, Wrap::Open, Wrap::Open, keep, f)
    }

    /// A tube, `w` quads around and `h` along it, open at both ends. `f` gets the angle and 0..=1 along.
    pub fn tube(w: usize, h: usize, f: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        Self::grid(w, h, Wrap::Closed, Wrap::Open, |_, _| true, |u, v| f(TAU * u, v))
    }

    /// A grid of `w` x `h` quads whose sides may meet, without the quads that `keep` drops.
    pub fn grid(
        w: usize,
        h: usize,
        across: Wrap,
        along: Wrap,
        keep: impl Fn(usize, usize) -> bool,
        f: impl Fn(f64, f64) -> [f64; 3],
    ) -> Self {
        let row = w + 1;
        let id = |i: usize, j: usize| {
            // A twist of one direction turns the other one over.
            let (i, j) = match (i == w, across) {
                (true, Wrap::Closed) => (0, j),
                (true, Wrap::Twisted) => (0, h - j),
                _ => (i, j),
            };
            let (i, j) = match (j == h, along) {
                (true, Wrap::Closed) => (i, 0),
                (true, Wrap::Twisted) => (w - i, 0),
                _ => (i, j),
            };
            // The first column again, where the second turn led to its other end.
            let i = if i == w && across == Wrap::Closed { 0 } else { i };
            (j * row + i) as u32
        };
        let mut out = Self::default();
        for k in 0..row * (h + 1) {
            out.positions.push(f((k % row) as f64 / w as f64, (k / row) as f64 / h as f64));
        }
        for j in 0..h {
            for i in (0..w).filter(|&i| keep(i, j)) {
                out.quad([id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
            }
        }
        out.compacted()
    }

    /// A sphere of `w` x `h` quads whose poles are fans; `radius` of the direction.
    pub fn sphere(w: usize, h: usize, radius: impl Fn([f64; 3]) -> f64) -> Self {
        let mut out = Self::default();
        let at = |lon: f64, lat: f64| {
            let d = [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()];
            d.map(|x| x * radius(d))
        };
        let quarter = 0.25 * TAU;
        for j in 1..h {
            let lat = quarter * (2.0 * j as f64 / h as f64 - 1.0);
            out.positions.extend((0..w).map(|i| at(TAU * i as f64 / w as f64, lat)));
        }
        let (south, north) = (out.positions.len() as u32, out.positions.len() as u32 + 1);
        out.positions.extend([at(0.0, -quarter), at(0.0, quarter)]);
        let id = |i: usize, j: usize| (j * w + i % w) as u32;
        for i in 0..w {
            out.triangles.push([south, id(i + 1, 0), id(i, 0)]);
            out.triangles.push([north, id(i, h - 2), id(i + 1, h - 2)]);
        }
        for j in 0..h - 2 {
            for i in 0..w {
                out.quad([id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
            }
        }
        out
    }

    /// Two triangles.
    pub fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Three vertices of their own and the triangle between them.
    pub fn loose(&mut self, corners: [[f64; 3]; 3]) {
        let n = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.push([n, n + 1, n + 2]);
    }

    /// Adds another mesh; no vertex is shared.
    pub fn join(&mut self, other: &Shape) {
        let n = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + n)));
    }

    /// Every position replaced.
    pub fn moved(mut self, f: impl FnMut([f64; 3]) -> [f64; 3]) -> Self {
        self.positions = self.positions.into_iter().map(f).collect();
        self
    }

    /// Without the vertices that no triangle uses.
    pub fn compacted(&self) -> Self {
        let mut number = vec![NONE; self.positions.len()];
        let mut out = Self::default();
        for t in &self.triangles {
            out.triangles.push(t.map(|v| {
                let slot = &mut number[v as usize];
                if *slot == NONE {
                    *slot = out.positions.len() as u32;
                    out.positions.push(self.positions[v as usize]);
                }
                *slot
            }));
        }
        out
    }

    /// Corners of the box around all vertices; zeros without any.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let Some(&first) = self.positions.first() else { return Default::default() };
        let pick = |f: fn(f64, f64) -> f64| [0, 1, 2].map(|c| self.positions.iter().fold(first[c], |m, p| f(m, p[c])));
        (pick(f64::min), pick(f64::max))
    }

    /// Length of the diagonal of [`Shape::bounds`] \[m\].
    pub fn diagonal(&self) -> f64 {
        let (lo, hi) = self.bounds();
        (0..3).map(|c| (hi[c] - lo[c]).powi(2)).sum::<f64>().sqrt()
    }

    /// The text of an OBJ file; every digit is kept.
    pub fn obj(&self) -> String {
        let mut out = String::new();
        for [x, y, z] in &self.positions {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "v {x} {y} {z}");
        }
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| v + 1);
            let _ = writeln!(out, "f {a} {b} {c}");
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gimage::topology::Topology;

    #[test]
    fn grids_have_the_topology_of_their_wraps() {
        let flat = |u: f64, v: f64| [u, v, 0.0];
        let of = |a, b| Topology::of(&Shape::grid(8, 6, a, b, |_, _| true, flat).triangles);
        let figures = |t: Topology| (t.euler, t.boundary_loops, t.misoriented_edges > 0);
        assert_eq!(figures(of(Wrap::Open, Wrap::Open)), (1, 1, false));
        assert_eq!(figures(of(Wrap::Closed, Wrap::Open)), (0, 2, false));
        assert_eq!(figures(of(Wrap::Twisted, Wrap::Open)), (0, 1, true));
        assert_eq!(figures(of(Wrap::Closed, Wrap::Closed)), (0, 0, false));
        assert_eq!(figures(of(Wrap::Closed, Wrap::Twisted)), (0, 0, true));
        let ball = Topology::of(&Shape::sphere(8, 6, |_| 1.0).triangles);
        assert_eq!((ball.euler, ball.boundary_loops, ball.misoriented_edges), (2, 0, 0));
    }

    #[test]
    fn an_obj_keeps_every_digit() {
        let mut s = Shape::default();
        s.loose([[0.1 + 0.2, 1e-18, -1e18], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let text = s.obj();
        let x: Vec<f64> = text.lines().next().unwrap()[2..].split(' ').map(|w| w.parse().unwrap()).collect();
        assert_eq!(x, s.positions[0]);
        assert!(text.ends_with("f 1 2 3\n"));
    }
}
