//! Separates the pieces of a garment from its accessories, by connectedness and area.

mod names;
mod overlay;
mod topology;

use std::cmp::Ordering;
use std::path::Path;

use crate::base::mesh::Mesh;
use crate::base::order;
use crate::base::surface::Surface;
use crate::base::words;
use crate::error::Error;
use crate::options::{Range, stage_options};
use crate::record::{Finding, MAX_EXAMPLES, Severity};

stage_options! {
    /// Options of [`split`].
    pub struct ComponentOptions of "component" {
        /// Parts below this share of the total area become accessories; with 0 every part is a piece. Larger parts than the
        /// range allows are always pieces.
        pub accessory_area: f64 = 0.01 => "accessory-area" ["share"] Range::Between(0.0, ALWAYS_PIECE);
    }
}

/// Share of the total area from which a component is always a piece, whatever else would make it an accessory.
pub const ALWAYS_PIECE: f64 = 0.1;

/// A connected part of a repaired mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Its triangles in the mesh, ascending.
    pub triangles: Vec<u32>,
    /// Unique among the components of the mesh (also when letter case is ignored), fit for a file name, never empty.
    pub name: String,
    /// Area \[m2\].
    pub area: f64,
    /// Vertices - edges + triangles.
    pub euler: i64,
    /// Boundary loops, 0 for a closed component.
    pub loops: usize,
    /// Whether it has two sides.
    pub orientable: bool,
    /// Handles, `(2 - euler - loops) / 2`; of a component that is not orientable the cross-caps, `2 - euler - loops` (a
    /// Moebius strip has 1, a Klein bottle 2).
    pub genus: u32,
    /// Corners of its axis-aligned box \[m\].
    pub bounds: ([f64; 3], [f64; 3]),
    /// The name of the larger component that it lies on all over, if it does: a print that was modelled as a copy of faces.
    pub lies_on: Option<String>,
}

/// The components of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Split {
    /// Components that become images: the largest area first, equal areas by their first triangle. Empty if no component is large
    /// enough, or nothing has any area; a finding `no-piece` then reports it.
    pub pieces: Vec<Component>,
    /// Components that are too small, in the same order, then those that lie on a larger one. Empty if nothing has any area.
    pub accessories: Vec<Component>,
    /// Findings for the user.
    pub findings: Vec<Finding>,
}

/// Splits a repaired mesh into its components. O(n log n).
pub fn split(mesh: &Mesh, options: &ComponentOptions) -> Split {
    split_counting(mesh, options, &|_| 0.0)
}

/// As [`split`], but each component counts for more than its own area, by `beside` \[m2\]: a thin shell for both of its sheets, so
/// that the choice of pieces does not depend on how many of them are left.
pub(crate) fn split_counting(mesh: &Mesh, options: &ComponentOptions, beside: &dyn Fn(&Component) -> f64) -> Split {
    let mut found = topology::components(mesh);
    let counted = |c: &Component| c.area + beside(c);
    found.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.triangles[0].cmp(&b.triangles[0])));
    let total: f64 = found.iter().map(counted).sum();
    let mut out = Split::default();
    if total <= 0.0 || !total.is_finite() {
        let (components, triangles) = (words::components(found.len()), words::triangles(mesh.triangles.len()));
        let message = format!("no component has any area ({components}, {triangles})");
        out.findings.push(finding(Severity::Warning, "no-piece", found.len(), Vec::new(), message));
        return out;
    }
    names::assign(mesh, &mut found);
    let share = |c: &Component| counted(c) / total;
    let least = options.accessory_area.min(ALWAYS_PIECE);
    (out.pieces, out.accessories) = found.into_iter().partition(|c| counted(c) >= least * total);

    let example = |c: &Component| {
        format!("{}: {}, {:.2} % of the area", c.name, words::triangles(c.triangles.len()), 100.0 * share(c))
    };
    let examples: Vec<String> = out.accessories.iter().take(MAX_EXAMPLES).map(example).collect();
    let (count, limit) = (out.accessories.len(), 100.0 * least);
    if out.pieces.is_empty() {
        let message =
            format!("none of {} has {limit} % of the area; the largest is {}", words::components(count), examples[0]);
        out.findings.push(finding(Severity::Warning, "no-piece", count, examples, message));
    } else if count > 0 {
        let triangles: usize = out.accessories.iter().map(|c| c.triangles.len()).sum();
        let area: f64 = out.accessories.iter().map(share).sum();
        let message = format!(
            "{} under {limit} % of the area made accessories: {}, {:.2} % of the area",
            words::components(count),
            words::triangles(triangles),
            100.0 * area
        );
        out.findings.push(finding(Severity::Repair, "accessories", count, examples, message));
    }
    // With an area of 0 every part is a piece.
    let overlays = if least > 0.0 { overlay::take(mesh, &mut out.pieces, share) } else { Vec::new() };
    if !overlays.is_empty() {
        let on = |c: &Component| format!("{} lies on {}", c.name, c.lies_on.as_deref().unwrap_or_default());
        let examples = overlays.iter().take(MAX_EXAMPLES).map(on).collect();
        let message = format!("{} on a larger one all over made accessories", words::components(overlays.len()));
        out.findings.push(finding(Severity::Repair, "overlays", overlays.len(), examples, message));
    }
    out.accessories.extend(overlays);
    out
}

/// The error for a file of which repair leaves nothing that has an area.
pub(crate) fn no_area(path: &Path) -> Error {
    Error::Empty {
        path: path.to_path_buf(),
        problem: "no triangle with an area is left after repair".into(),
        hint: "export the garment's mesh again".into(),
    }
}

fn finding(severity: Severity, kind: &'static str, count: usize, examples: Vec<String>, message: String) -> Finding {
    Finding { severity, stage: "component", kind, count: count as u64, examples, message }
}

/// Extracts a component as a surface. Vertices come in the order of their places on the shape (`base/order.rs`) and
/// triangles in that of their vertices, so that what is made of the surface depends neither on the order of the file nor on how the shape
/// stands. O(n log n) in the component, O(n) in the mesh's vertices.
pub fn extract(mesh: &Mesh, component: &Component) -> Surface {
    let mut used: Vec<u32> = component.triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    used.sort_unstable();
    used.dedup();
    let at = |v: u32| mesh.positions[v as usize];
    let positions: Vec<[f64; 3]> = used.iter().map(|&v| at(v)).collect();
    let mut number = vec![u32::MAX; mesh.positions.len()];
    used.iter().enumerate().for_each(|(k, &v)| number[v as usize] = k as u32);
    let triangles = component.triangles.iter().map(|&t| mesh.triangles[t as usize].map(|v| number[v as usize]));
    let places = order::places(&positions, triangles);
    let mut order: Vec<usize> = (0..used.len()).collect();
    let exact = |a: [f64; 3], b: [f64; 3]| (0..3).fold(Ordering::Equal, |o, c| o.then(a[c].total_cmp(&b[c])));
    order.sort_unstable_by(|&a, &b| {
        places[a].cmp(&places[b]).then_with(|| exact(positions[a], positions[b])).then(a.cmp(&b))
    });
    let used: Vec<u32> = order.iter().map(|&k| used[k]).collect();
    let mut to = number;
    used.iter().enumerate().for_each(|(k, &v)| to[v as usize] = k as u32);
    // The least vertex first: where a file begins a triangle is chance too.
    let mut triangles: Vec<([u32; 3], u32, u8)> = component
        .triangles
        .iter()
        .map(|&t| {
            let mut corners = mesh.triangles[t as usize].map(|v| to[v as usize]);
            let first = (0..3).fold(0, |m, k| if corners[k] < corners[m] { k } else { m });
            corners.rotate_left(first);
            (corners, t, first as u8)
        })
        .collect();
    triangles.sort_unstable_by_key(|&([a, b, c], t, _)| ([a, b.min(c), b.max(c)], b, t));
    Surface {
        positions: used.iter().map(|&v| at(v)).collect(),
        triangles: triangles.iter().map(|t| t.0).collect(),
        source_triangle: triangles.iter().map(|t| t.1).collect(),
        first_corner: triangles.iter().map(|t| t.2).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Part;

    fn mesh() -> Mesh {
        // A unit square, a button of a hundredth of an area under the same name, and a strip apart.
        let positions =
            [[0., 0.], [1., 0.], [1., 1.], [0., 1.], [5., 0.], [5.1, 0.], [5., 0.1], [7., 0.], [9., 0.], [7., 2.]];
        let part = |node: &str, mesh: &str| Part { node: node.into(), mesh: mesh.into(), ..Default::default() };
        Mesh {
            positions: positions.map(|[x, y]| [x, y, 0.0]).to_vec(),
            triangles: vec![[4, 5, 6], [0, 1, 2], [7, 8, 9], [0, 2, 3]],
            triangle_part: vec![0, 0, 1, 0],
            parts: vec![part("Shirt front", "x"), part("", "a/b")],
            ..Default::default()
        }
    }

    #[test]
    fn pieces_come_by_area_with_names() {
        let s = split(&mesh(), &ComponentOptions::default());
        let names: Vec<&str> = s.pieces.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["a_b", "Shirt_front"]);
        assert_eq!(s.accessories[0].name, "Shirt_front_2");
        assert_eq!(s.pieces[1].triangles, [1, 3]);
        assert_eq!((s.pieces[1].euler, s.pieces[1].loops, s.pieces[1].genus), (1, 1, 0));
        assert_eq!(s.pieces[1].bounds, ([0.; 3], [1., 1., 0.]));
        assert_eq!((s.findings[0].kind, s.findings[0].count), ("accessories", 1));
    }

    #[test]
    fn extract_maps_back() {
        let m = mesh();
        let s = split(&m, &ComponentOptions::default());
        let surface = extract(&m, &s.pieces[1]);
        assert_eq!(surface.positions.len(), 4);
        let mut sources = surface.source_triangle.clone();
        sources.sort_unstable();
        assert_eq!(sources, [1, 3]);
        for t in 0..2 {
            let source = m.corners(surface.source_triangle[t] as usize);
            assert!((0..3).all(|c| surface.corners(t)[c] == source[surface.source_corner(t, c)]));
            let [first, others @ ..] = surface.triangles[t];
            assert!(others.iter().all(|&v| v > first));
        }
    }

    #[test]
    fn the_order_of_the_file_does_not_matter() {
        let m = mesh();
        let mut turned = m.clone();
        turned.positions.reverse();
        turned.triangles.iter_mut().for_each(|t| *t = t.map(|v| 9 - v));
        turned.triangles[0].rotate_left(1);
        turned.triangles.swap(1, 3);
        let (a, b) = (split(&m, &ComponentOptions::default()), split(&turned, &ComponentOptions::default()));
        for (x, y) in a.pieces.iter().zip(&b.pieces) {
            let (x, y) = (extract(&m, x), extract(&turned, y));
            assert_eq!((x.positions, x.triangles), (y.positions, y.triangles));
        }
    }

    /// `n` triangles of one size.
    fn confetti(n: u32) -> Mesh {
        let corners = |k: u32| [[0., 0.], [1., 0.], [0., 1.]].map(|[x, y]| [x + 2.0 * f64::from(k), y, 0.0]);
        Mesh {
            positions: (0..n).flat_map(corners).collect(),
            triangles: (0..n).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
            triangle_part: vec![0; n as usize],
            ..Default::default()
        }
    }

    #[test]
    fn a_tenth_of_the_area_is_never_an_accessory() {
        let s = split(&confetti(10), &ComponentOptions { accessory_area: 0.9 });
        assert_eq!((s.pieces.len(), s.accessories.len()), (10, 0));
        let s = split(&confetti(11), &ComponentOptions { accessory_area: 0.9 });
        assert_eq!((s.pieces.len(), s.accessories.len()), (0, 11));
    }

    #[test]
    fn nothing_large_enough_is_said() {
        let s = split(&confetti(20), &ComponentOptions { accessory_area: 0.1 });
        assert!(s.pieces.is_empty());
        assert_eq!((s.accessories.len(), s.findings[0].kind), (20, "no-piece"));
        let nothing = split(&Mesh::default(), &ComponentOptions::default());
        assert!(nothing.pieces.is_empty() && nothing.accessories.is_empty());
    }
}
