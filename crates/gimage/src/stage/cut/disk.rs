//! A cut surface as a topological disk: vertices split along the cut, triangles turned one way, one boundary loop.

use gimage_bundle::DisjointSets;

use crate::base::halfedge::{self, BOUNDARY, next, origin, target};
use crate::base::vec3::{distance, lerp};
use crate::stage::cut::corners::Corners;
use crate::stage::cut::{Cut, Cutter};
use crate::stage::parameterize::Shape;

/// A vertex that is not a vertex of the surface.
pub const NONE: u32 = u32::MAX;

/// A triangulated disk that remembers the surface it was cut from.
#[derive(Clone, Debug, Default)]
pub struct Disk {
    /// Vertex positions \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Counter-clockwise triangles.
    pub triangles: Vec<[u32; 3]>,
    /// The surface vertex each vertex is a copy of, or [`NONE`] for one made by splitting an edge.
    pub origin: Vec<u32>,
    /// For each triangle, the surface triangle it lies in.
    pub face: Vec<u32>,
    /// Barycentric coordinates of its corners in that triangle.
    pub corners: Corners,
    /// The length a unit of length counts for at each vertex: more where texels are wanted denser.
    pub wanted: Vec<f64>,
    /// The boundary loop, counter-clockwise.
    pub boundary: Vec<u32>,
    /// For each boundary edge (from `boundary[i]` to the next), whether it lies on the cut.
    pub on_cut: Vec<bool>,
}

/// Why a cut did not give a disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotADisk {
    /// Vertices - edges + triangles of what came out.
    pub euler: i64,
    /// Its boundary loops.
    pub loops: usize,
}

/// Splits the surface along the cut.
pub(crate) fn open(cutter: &Cutter<'_>, cut: &Cut) -> Result<Disk, NotADisk> {
    let (surface, graph) = (cutter.surface, &cutter.graph);
    let mut triangles = surface.triangles.clone();
    let mut corners = Corners::whole(triangles.len());
    let uncut = |h: u32| {
        let e = graph.of_half[h as usize] as usize;
        let [a, b] = graph.halves[e];
        if cut.edges[e] || b == BOUNDARY { BOUNDARY } else { a ^ b ^ h }
    };
    // Turn all triangles one way across uncut edges; a non-orientable surface is orientable once cut.
    let mut turned = vec![None; triangles.len()];
    turned[0] = Some(false);
    let mut queue = vec![0u32];
    while let Some(t) = queue.pop() {
        for h in 3 * t..3 * t + 3 {
            let w = uncut(h);
            if w != BOUNDARY && turned[w as usize / 3].is_none() {
                let opposite = origin(&surface.triangles, h) == target(&surface.triangles, w);
                turned[w as usize / 3] = Some(turned[t as usize].unwrap_or(false) == opposite);
                queue.push(w / 3);
            }
        }
    }
    // As most of the area winds.
    if turned.contains(&Some(true)) {
        let area = |t: usize| surface.triangle_area(t);
        let against: f64 = (0..triangles.len()).map(|t| if turned[t] == Some(true) { area(t) } else { -area(t) }).sum();
        if against > 0.0 {
            turned.iter_mut().flatten().for_each(|turned| *turned = !*turned);
        }
    }
    // Corners that stay together, as sets.
    let corner_count = 3 * triangles.len();
    let mut sets = DisjointSets::new(corner_count);
    for h in 0..corner_count as u32 {
        let w = uncut(h);
        if w == BOUNDARY || w < h {
            continue;
        }
        let same = origin(&surface.triangles, h) == origin(&surface.triangles, w);
        for (a, b) in if same { [(h, w), (next(h), next(w))] } else { [(h, next(w)), (next(h), w)] } {
            sets.union(a, b);
        }
    }
    let (mut vertex, mut origins) = (vec![NONE; corner_count], Vec::new());
    for c in 0..corner_count as u32 {
        let r = sets.find(c);
        if r == c {
            vertex[c as usize] = origins.len() as u32;
            origins.push(surface.triangles[c as usize / 3][c as usize % 3]);
        }
    }
    for (t, tri) in triangles.iter_mut().enumerate() {
        *tri = [0, 1, 2].map(|k| vertex[sets.find(3 * t as u32 + k) as usize]);
        if turned[t] == Some(true) {
            tri.swap(1, 2);
            corners.turn(t);
        }
    }
    let positions = origins.iter().map(|&v| surface.positions[v as usize]).collect();
    let face = (0..triangles.len() as u32).collect();
    let wanted = origins.iter().map(|&v| cutter.wanted[v as usize]).collect();
    let mut disk =
        Disk { positions, triangles, origin: origins, face, corners, wanted, boundary: vec![], on_cut: vec![] };
    disk.find_boundary(|h| {
        // A turned triangle's edges run in the other order.
        let t = h as usize / 3;
        let k = if turned[t] == Some(true) { [2, 1, 0][h as usize % 3] } else { h as usize % 3 };
        let e = graph.of_half[3 * t + k] as usize;
        !graph.is_boundary(e)
    })?;
    Ok(disk)
}

impl Disk {
    /// Finds the boundary loop, counter-clockwise, and checks that this is a disk.
    fn find_boundary(&mut self, on_cut: impl Fn(u32) -> bool) -> Result<(), NotADisk> {
        let euler = halfedge::euler(&self.triangles);
        let Ok(twin) = halfedge::twins(&self.triangles) else { return Err(NotADisk { euler, loops: 0 }) };
        let loops = halfedge::boundary_loops(&self.triangles, &twin).unwrap_or_default();
        if euler != 1 || loops.len() != 1 {
            return Err(NotADisk { euler, loops: loops.len() });
        }
        let mut leaving = vec![NONE; self.positions.len()];
        for h in (0..twin.len() as u32).filter(|&h| twin[h as usize] == BOUNDARY) {
            leaving[origin(&self.triangles, h) as usize] = h;
        }
        let start = loops[0][0];
        let (mut boundary, mut cut, mut v) = (Vec::new(), Vec::new(), start);
        loop {
            let h = leaving[v as usize];
            if h == NONE || boundary.len() > loops[0].len() {
                return Err(NotADisk { euler, loops: 1 });
            }
            boundary.push(v);
            cut.push(on_cut(h));
            v = target(&self.triangles, h);
            if v == start {
                break;
            }
        }
        (self.boundary, self.on_cut) = (boundary, cut);
        Ok(())
    }

    /// Room for what is to be added and no more: a list that doubles would hold as much again for as long as the disk lives.
    fn reserve(&mut self, vertices: usize, triangles: usize) {
        self.positions.reserve_exact(vertices);
        self.origin.reserve_exact(vertices);
        self.wanted.reserve_exact(vertices);
        self.triangles.reserve_exact(triangles);
        self.corners.reserve(triangles);
        self.face.reserve_exact(triangles);
    }

    /// Adds a vertex at `t` from `a` to `b` on the edge that `faces` share, splitting them; the part that keeps `b` is
    /// appended.
    fn split_edge(&mut self, a: u32, b: u32, t: f64, faces: &[u32]) -> u32 {
        let new = self.positions.len() as u32;
        self.positions.push(lerp(self.positions[a as usize], self.positions[b as usize], t));
        self.origin.push(NONE);
        self.wanted.push((1.0 - t) * self.wanted[a as usize] + t * self.wanted[b as usize]);
        for &f in faces {
            let f = f as usize;
            let tri = self.triangles[f];
            let Some(k) = (0..3).find(|&k| {
                let e = [tri[k], tri[(k + 1) % 3]];
                e == [a, b] || e == [b, a]
            }) else {
                continue;
            };
            let (i, j) = (k, (k + 1) % 3);
            let s = if tri[i] == a { t } else { 1.0 - t };
            let corners = self.corners.of(f);
            let middle = lerp(corners[i], corners[j], s);
            let (mut first, mut second) = (tri, tri);
            let (mut first_corners, mut second_corners) = (corners, corners);
            first[j] = new;
            first_corners[j] = middle;
            second[i] = new;
            second_corners[i] = middle;
            self.triangles[f] = first;
            self.triangles.push(second);
            self.corners.split(f, first_corners, second_corners);
            self.face.push(self.face[f]);
        }
        new
    }

    /// Splits boundary edges: `at` lists (index in `boundary`, fraction along that edge), the fractions in (0, 1).
    /// `boundary` and `on_cut` gain the new vertices in order.
    pub(crate) fn split_boundary(&mut self, at: &[(usize, f64)]) {
        if at.is_empty() {
            return;
        }
        let mut at = at.to_vec();
        at.sort_by(|x, y| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)));
        self.reserve(at.len(), at.len());
        let mut face_of = std::collections::HashMap::new();
        let n = self.boundary.len();
        for (i, _) in &at {
            face_of.insert([self.boundary[*i], self.boundary[(i + 1) % n]], NONE);
        }
        for (f, t) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                if let Some(x) = face_of.get_mut(&[t[k], t[(k + 1) % 3]]) {
                    *x = f as u32;
                }
            }
        }
        let (mut boundary, mut on_cut, mut next_at) = (Vec::with_capacity(n + at.len()), Vec::new(), 0);
        for i in 0..n {
            let (a, b) = (self.boundary[i], self.boundary[(i + 1) % n]);
            boundary.push(a);
            on_cut.push(self.on_cut[i]);
            let (mut from, mut low) = (a, 0.0);
            let mut face = face_of.get(&[a, b]).copied().unwrap_or(NONE);
            while next_at < at.len() && at[next_at].0 == i {
                let s = at[next_at].1;
                let new = self.split_edge(from, b, ((s - low) / (1.0 - low)).clamp(1e-12, 1.0 - 1e-12), &[face]);
                // The triangle just appended holds (new, b), and perhaps another boundary edge to be split.
                face = self.triangles.len() as u32 - 1;
                let tail = self.triangles[face as usize];
                for k in 0..3 {
                    if let Some(x) = face_of.get_mut(&[tail[k], tail[(k + 1) % 3]]) {
                        *x = face;
                    }
                }
                boundary.push(new);
                on_cut.push(self.on_cut[i]);
                (from, low) = (new, s);
                next_at += 1;
            }
        }
        (self.boundary, self.on_cut) = (boundary, on_cut);
    }

    /// Splits at their middle all inner edges that join two boundary vertices: on a straight side of the rectangle such
    /// an edge would flatten the triangles behind it. Returns how many.
    pub(crate) fn split_chords(&mut self) -> usize {
        let mut on_boundary = vec![false; self.positions.len()];
        self.boundary.iter().for_each(|&v| on_boundary[v as usize] = true);
        let mut chords = Vec::new();
        for run in halfedge::sorted_edges(&self.triangles).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            if let [x, y] = run
                && on_boundary[x.0 as usize]
                && on_boundary[x.1 as usize]
            {
                chords.push((x.0, x.1, [x.2 / 3, y.2 / 3]));
            }
        }
        let many = chords.len();
        self.reserve(many, 2 * many);
        // A split changes its two triangles, and another chord may be in the parts split off: follow the parts.
        let mut parts: std::collections::HashMap<u32, Vec<u32>> = std::collections::HashMap::new();
        for (a, b, faces) in chords {
            let mut holders = Vec::with_capacity(2);
            for f in faces {
                let family = parts.get(&f).cloned().unwrap_or_else(|| vec![f]);
                holders.extend(family.into_iter().filter(|&g| {
                    let t = self.triangles[g as usize];
                    t.contains(&a) && t.contains(&b)
                }));
            }
            let before = self.triangles.len() as u32;
            self.split_edge(a, b, 0.5, &holders);
            for k in 0..holders.len() {
                let root = faces[k.min(1)];
                parts.entry(root).or_insert_with(|| vec![root]).push(before + k as u32);
            }
        }
        many
    }

    /// Length of the edge between two vertices as the map is to see it.
    pub(crate) fn length(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (a as usize, b as usize);
        0.5 * (self.wanted[a] + self.wanted[b]) * distance(self.positions[a], self.positions[b])
    }

    /// Which vertices lie on the boundary.
    pub(crate) fn boundary_mask(&self) -> Vec<bool> {
        let mut mask = vec![false; self.positions.len()];
        self.boundary.iter().for_each(|&v| mask[v as usize] = true);
        mask
    }

    /// The shape to map, with these vertices in their places.
    pub(crate) fn shape<'a>(&'a self, fixed: &'a [bool]) -> Shape<'a> {
        Shape { positions: &self.positions, triangles: &self.triangles, wanted: &self.wanted, fixed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use crate::base::surface::Surface;
    use crate::base::vec3::{cross, distance, norm, sub};
    use crate::stage::parameterize::distortion::{planar, signed_area2};
    use proptest::prelude::*;

    fn area(d: &Disk) -> f64 {
        d.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| d.positions[v as usize]);
                0.5 * norm(cross(sub(b, a), sub(c, a)))
            })
            .sum()
    }

    /// A disk that covers the surface, its parts all telling the truth about one another.
    fn check(d: &Disk, s: &Surface) {
        assert!((area(d) - s.area()).abs() < 1e-9 * s.area());
        assert_eq!(halfedge::euler(&d.triangles), 1);
        let twin = halfedge::twins(&d.triangles).unwrap();
        assert_eq!(halfedge::boundary_loops(&d.triangles, &twin).unwrap().len(), 1);
        assert_eq!(twin.iter().filter(|&&t| t == BOUNDARY).count(), d.boundary.len());
        assert_eq!(d.on_cut.len(), d.boundary.len());
        let outer: std::collections::HashSet<[u32; 2]> = (0..twin.len() as u32)
            .filter(|&h| twin[h as usize] == BOUNDARY)
            .map(|h| [origin(&d.triangles, h), target(&d.triangles, h)])
            .collect();
        for i in 0..d.boundary.len() {
            assert!(outer.contains(&[d.boundary[i], d.boundary[(i + 1) % d.boundary.len()]]));
        }
        for h in 0..twin.len() as u32 {
            let w = twin[h as usize];
            assert!(w == BOUNDARY || origin(&d.triangles, h) == target(&d.triangles, w), "neighbours wind apart");
        }
        for (t, tri) in d.triangles.iter().enumerate() {
            let source = s.corners(d.face[t] as usize);
            for (k, &v) in tri.iter().enumerate() {
                let p = [0, 1, 2].map(|c| (0..3).map(|m| d.corners.of(t)[k][m] * source[m][c]).sum::<f64>());
                assert!(distance(p, d.positions[v as usize]) < 1e-12);
                assert!((d.corners.of(t)[k].iter().sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
        for (p, &o) in d.positions.iter().zip(&d.origin) {
            assert!(o == NONE || *p == s.positions[o as usize]);
        }
    }

    fn chords(d: &Disk) -> usize {
        let mask = d.boundary_mask();
        halfedge::sorted_edges(&d.triangles)
            .chunk_by(|x, y| (x.0, x.1) == (y.0, y.1))
            .filter(|r| r.len() == 2 && mask[r[0].0 as usize] && mask[r[0].1 as usize])
            .count()
    }

    #[test]
    fn opening_keeps_the_surface_and_orients_it() {
        for (_, s) in shapes::all() {
            check(&shapes::opened(&s, &[]), &s);
        }
    }

    #[test]
    fn an_uncut_torus_is_no_disk() {
        let s = shapes::torus(6, 5);
        let cutter = Cutter::new(&s).unwrap();
        let cut = Cut { edges: vec![false; cutter.graph.ends.len()] };
        assert_eq!(open(&cutter, &cut).unwrap_err(), NotADisk { euler: 0, loops: 0 });
    }

    #[test]
    fn splits_of_one_triangle_keep_it_whole() {
        let s = shapes::surface(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
        let mut d = shapes::opened(&s, &[]);
        d.split_boundary(&[(2, 0.5), (0, 0.75), (1, 0.5), (0, 0.25)]);
        assert_eq!((d.triangles.len(), d.boundary.len()), (5, 7));
        check(&d, &s);
        let uv: Vec<[f64; 2]> = d.positions.iter().map(|p| [p[0], p[1]]).collect();
        assert!(d.triangles.iter().all(|&t| signed_area2(planar(&uv, t)) > 0.0));
        d.split_chords();
        assert_eq!(chords(&d), 0);
        check(&d, &s);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn random_splits_leave_a_disk_without_chords(
            seed in any::<u64>(), at in prop::collection::vec((any::<prop::sample::Index>(), 0.01f64..0.99), 0..12)
        ) {
            let s = shapes::blob(seed, 20, 6);
            let mut d = shapes::opened(&s, &[]);
            let n = d.boundary.len();
            let at: Vec<(usize, f64)> = at.into_iter().map(|(i, t)| (i.index(n), t)).collect();
            d.split_boundary(&at);
            prop_assert_eq!(d.boundary.len(), n + at.len());
            check(&d, &s);
            d.split_chords();
            prop_assert_eq!(chords(&d), 0);
            check(&d, &s);
        }
    }
}
