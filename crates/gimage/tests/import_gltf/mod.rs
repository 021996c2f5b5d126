//! glTF features, each on the smallest file that shows it.

mod attributes;
mod buffers;
mod scene;

use crate::support::check;

fn area(imported: &gimage::import::Imported) -> f64 {
    check(imported);
    (0..imported.mesh.triangles.len()).map(|t| imported.mesh.triangle_area(t)).sum()
}

fn face_normal(mesh: &gimage::Mesh, t: usize) -> [f64; 3] {
    let [a, b, c] = mesh.corners(t);
    let (u, v): ([f64; 3], [f64; 3]) = (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}
