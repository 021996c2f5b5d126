//! Meshes that are bound to a cloth that is cut: triangles over a cut fall away, those beside it stay.

use crate::support;
use crate::support::bound_mesh::{Vertex, bundle, flag_texel, sheet, tube_texel};
use gimage_bundle::Bundle;
use gimage_runtime::*;

const FRAME: f64 = 1.0 / 60.0;

/// A flag of 17 x 13 texels, 0.8 m wide and 0.6 m high, under a mesh of cells x cells quads.
fn flag(cells: u32) -> Bundle {
    bundle((17, 13), flag_texel, &sheet(cells))
}

/// A tube whose mesh has its quads across the seam of the piece: from u = 0.9 on to u = 0.1.
fn tube() -> Bundle {
    let mut vertices: Vec<Vertex> = sheet(10);
    for v in &mut vertices {
        let u = 0.05 + v.coord[1];
        v.coord[1] = if u > 1.0 { u - 1.0 } else { u };
    }
    bundle((13, 8), tube_texel, &vertices)
}

fn stepper(bundle: &Bundle) -> Stepper {
    let mut scene = Scene::new("cuts");
    scene.cloths.push(Cloth::from_bundle("cloth", bundle).unwrap());
    Stepper::on_cpu(scene, options()).unwrap()
}

fn options() -> Options {
    Options { substeps: Some(4), threads: 1, ..Options::default() }
}

/// Cuts the flag through along x = 0.41, and the tube beside its seam: its first column of texels, u = 0 to 1 / 12.
const CUTS: [[[f32; 3]; 3]; 2] = [
    [[0.41, -0.3, 3.0], [0.41, 1.2, -3.0], [0.41, -1.8, -3.0]],
    [[3.0, -0.1, 0.001], [0.05, 0.4, 0.001], [0.05, -0.9, 0.001]],
];

fn left(stepper: &Stepper, mesh: &RenderMesh) -> Vec<bool> {
    let indices = stepper.render_indices(0, mesh, stepper.holes(0).unwrap_or_default()).unwrap();
    assert_eq!(indices.len(), mesh.indices.len());
    let there = |(t, own): (&[u32], &[u32])| {
        let is_point = t == [own[0]; 3];
        assert!(is_point || t == own, "{t:?} of {own:?}");
        !is_point
    };
    indices.chunks_exact(3).zip(mesh.indices.chunks_exact(3)).map(there).collect()
}

#[test]
fn triangles_over_a_cut_fall_away_and_the_rest_stays() {
    // Finer than the texels, as fine, coarser, and two triangles in all.
    for cells in [60, 16, 5, 1] {
        let bundle = flag(cells);
        let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
        let mut stepper = stepper(&bundle);
        assert!(left(&stepper, &mesh).iter().all(|there| *there));
        let (mut at_start, mut after) = (Vec::new(), Vec::new());
        stepper.wrap(0, &mesh, 1.0, &mut at_start).unwrap();
        let [eye, a, b] = CUTS[0];
        stepper.cut(eye, a, b).unwrap();
        stepper.advance(FRAME).unwrap();
        let left = left(&stepper, &mesh);
        let cell = 0.8 / cells as f32;
        let mut gone = 0;
        for (t, there) in left.iter().enumerate() {
            let x = [0, 1, 2].map(|c| at_start[mesh.indices[3 * t + c] as usize].position[0]);
            let (low, high) = (x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2]));
            // The cut takes the column of texels from x = 0.4 to 0.45.
            if low < 0.4 - 1e-4 && high > 0.45 + 1e-4 || (low > 0.4 && high < 0.45) {
                assert!(!there, "{cells} cells: triangle {t}, {low} to {high}, spans the cut");
            }
            if high < 0.4 - 1e-4 || low > 0.45 + 1e-4 {
                assert!(there, "{cells} cells: triangle {t}, {low} to {high}, is beside the cut");
            }
            gone += usize::from(!there);
        }
        // At most the triangles that reach into that column.
        let columns = (0.05 / cell).ceil() as usize + 1;
        assert!(gone > 0 && gone <= 2 * cells as usize * columns, "{cells} cells: {gone} gone");
        // Both sides part, and each vertex of a triangle that is left stays near the other two.
        (0..40).for_each(|_| _ = stepper.advance(FRAME).unwrap());
        stepper.wrap(0, &mesh, 1.0, &mut after).unwrap();
        for (t, _) in left.iter().enumerate().filter(|(_, there)| **there) {
            let side = |list: &[RenderVertex], a: usize, b: usize| {
                let [a, b] = [a, b].map(|c| list[mesh.indices[3 * t + c] as usize].position);
                (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt()
            };
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let (was, is) = (side(&at_start, a, b), side(&after, a, b));
                assert!(is < 1.3 * was + 1e-3, "{cells} cells: a side of triangle {t} is {is} m long, {was} m at rest");
            }
        }
    }
}

#[test]
fn triangles_across_a_seam_fall_away_with_it_alone() {
    let bundle = tube();
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let mut stepper = stepper(&bundle);
    let [eye, a, b] = CUTS[1];
    stepper.cut(eye, a, b).unwrap();
    stepper.advance(FRAME).unwrap();
    let left = left(&stepper, &mesh);
    let vertices = support::bound_mesh::sheet(10);
    for (t, there) in left.iter().enumerate() {
        let u = [0, 1, 2].map(|c| vertices[mesh.indices[3 * t + c] as usize].coord[1] + 0.05);
        let (low, high) = (u[0].min(u[1]).min(u[2]), u[0].max(u[1]).max(u[2]));
        if low < 0.99 && high > 1.01 {
            assert!(!there, "triangle {t}, {low} to {high}, is over the cut");
        }
        if low > 1.0 / 12.0 + 1e-3 && high < 1.0 - 1e-3 {
            assert!(there, "triangle {t}, {low} to {high}, is beside the cut");
        }
    }
}

#[test]
fn a_state_brings_triangles_back_and_a_coarser_level_can_be_cut() {
    let bundle = flag(20);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let mut stepper = stepper(&bundle);
    stepper.set_level(0, 1).unwrap();
    let whole = stepper.state(0).unwrap();
    let [eye, a, b] = CUTS[0];
    stepper.cut(eye, a, b).unwrap();
    stepper.advance(FRAME).unwrap();
    let gone = left(&stepper, &mesh).iter().filter(|there| !*there).count();
    // Coarse texels are 10 cm wide: from x = 0.4 to 0.5.
    assert!((2 * 20 * 2..=2 * 20 * 4).contains(&gone), "{gone}");
    stepper.set_state(0, &whole).unwrap();
    assert!(left(&stepper, &mesh).iter().all(|there| *there));
    // Holes of another cloth.
    let error = stepper.render_indices(0, &mesh, &[0; 3]).unwrap_err().to_string();
    assert!(error.contains('3'), "{error}");
}

#[cfg(feature = "gpu")]
mod on_the_gpu {
    use super::*;
    use crate::support::adapter;

    #[test]
    fn the_index_buffer_is_that_of_the_twin() {
        let Some((device, queue)) = adapter::device() else { return };
        for (bundle, [eye, a, b]) in [(flag(20), CUTS[0]), (flag(1), CUTS[0]), (tube(), CUTS[1])] {
            let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
            for backend in [Backend::Gpu, Backend::Cpu] {
                let mut scene = Scene::new("cuts");
                scene.cloths.push(Cloth::from_bundle("cloth", &bundle).unwrap());
                let options = Options { backend, ..options() };
                let mut stepper = Stepper::new(scene, options, Some((&device, &queue))).unwrap();
                let span = stepper.render_index_buffer(0, &mesh).unwrap();
                let mut twin = super::stepper(&bundle);
                let frame = |stepper: &mut Stepper| {
                    let mut encoder = device.create_command_encoder(&Default::default());
                    stepper.record(&mut encoder, FRAME).unwrap();
                    queue.submit([encoder.finish()]);
                    assert_eq!(stepper.render_index_buffer(0, &mesh).unwrap(), span);
                    read_back_u32(&device, &queue, &span).unwrap()
                };
                assert_eq!(frame(&mut stepper), mesh.indices);
                let whole = stepper.state(0).unwrap();
                for stepper in [&mut stepper, &mut twin] {
                    stepper.cut(eye, a, b).unwrap();
                }
                twin.advance(FRAME).unwrap();
                let want = twin.render_indices(0, &mesh, twin.holes(0).unwrap()).unwrap();
                assert!(want != mesh.indices);
                assert_eq!(frame(&mut stepper), want, "{backend:?}");
                // Asked for after the cut.
                let again = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
                let late = stepper.render_index_buffer(0, &again).unwrap();
                let mut encoder = device.create_command_encoder(&Default::default());
                stepper.record(&mut encoder, 0.0).unwrap();
                queue.submit([encoder.finish()]);
                assert_eq!(read_back_u32(&device, &queue, &late).unwrap(), want, "{backend:?}");
                stepper.set_state(0, &whole).unwrap();
                let mut encoder = device.create_command_encoder(&Default::default());
                stepper.record(&mut encoder, 0.0).unwrap();
                queue.submit([encoder.finish()]);
                assert_eq!(read_back_u32(&device, &queue, &late).unwrap(), mesh.indices, "{backend:?}");
            }
        }
    }
}
