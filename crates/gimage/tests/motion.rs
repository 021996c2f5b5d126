//! Surfaces in motion, written as glTF and USD and read back.

use gimage::export::motion::{GltfMotion, MAX_TARGETS, MotionWriter, Part, Shown, UsdMotion};
use gimage::reconstruct::{PieceView, ReconstructedPiece, Reconstruction, reconstruct};
use gimage::{Error, Result};

/// The position map of a tube along y, whose first and last columns are one seam.
fn tube(width: u32, height: u32, first_particle: u32) -> Vec<[f32; 4]> {
    let texel = |(j, i): (u32, u32)| {
        let angle = std::f32::consts::TAU * (i % (width - 1)) as f32 / (width - 1) as f32;
        let other = [(0, width - 1), (width - 1, 0)].into_iter().find(|(of, _)| *of == i);
        let code = other.map_or(1, |(_, other)| first_particle + j * width + other + 2);
        [0.1 * angle.cos(), j as f32 / height as f32, 0.1 * angle.sin(), code as f32]
    };
    (0..height).flat_map(|j| (0..width).map(move |i| (j, i))).map(texel).collect()
}

fn piece_triangles<'a>(surface: &'a Reconstruction, piece: &ReconstructedPiece) -> &'a [[u32; 3]] {
    &surface.triangles[piece.triangles.clone()]
}

/// Two welded tubes, one with texture coordinates that have a seam.
fn sample() -> Reconstruction {
    let (position, second) = (tube(9, 5, 0), tube(9, 5, 45));
    let uv: Vec<[f32; 2]> = (0..45).map(|k| [(k % 9) as f32 / 8.0, (k / 9) as f32 / 4.0]).collect();
    let (width, height) = (9, 5);
    reconstruct(&[
        PieceView { name: "left", width, height, first_particle: 0, position: &position, uv: Some(&uv) },
        PieceView { name: "a \"b\"", width, height, first_particle: 45, position: &second, uv: None },
    ])
    .unwrap()
}

/// The sample in motion: the first piece moves as a whole, one vertex of the second moves alone.
fn frames(count: usize) -> Vec<Reconstruction> {
    let move_to = |frame: usize| {
        let mut surface = sample();
        let first = surface.triangles[surface.pieces[0].triangles.clone()].as_flattened().iter().max().unwrap() + 1;
        let t = 0.1 * frame as f32;
        for p in &mut surface.positions[..first as usize] {
            p[0] += t * p[1].sin();
            p[2] -= t * t;
        }
        surface.positions[first as usize + 3][1] += t;
        surface
    };
    (0..count).map(move_to).collect()
}

/// The same, where the last triangles of the second piece are missing from frame `from` on.
fn cut(count: usize, from: usize) -> Vec<Reconstruction> {
    let mut all = frames(count);
    for surface in &mut all[from..] {
        surface.triangles.truncate(surface.triangles.len() - 4);
        surface.pieces[1].triangles.end -= 4;
    }
    all
}

fn written(mut writer: Box<dyn MotionWriter>, frames: &[Reconstruction]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    for (k, surface) in frames.iter().enumerate() {
        bytes.extend(writer.frame(surface, k as f64 / 30.0)?);
    }
    let part = |part| match part {
        Part::Bytes(list) => list,
        Part::Written(range) => bytes[range.start as usize..range.end as usize].to_vec(),
    };
    Ok(writer.finish()?.into_iter().flat_map(part).collect())
}

fn glb(shown: Shown, frames: &[Reconstruction]) -> Vec<u8> {
    written(Box::new(GltfMotion::new(shown, frames.len())), frames).unwrap()
}

/// A mesh of a file, with what its node and the node above have.
struct Shape {
    name: String,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    uv: Option<Vec<[f32; 2]>>,
    /// Keys of the scale of the node above: time and value.
    shown: Vec<(f32, f32)>,
    times: Vec<f32>,
    /// A row of weights per time.
    weights: Vec<f32>,
    targets: Vec<Vec<[f32; 3]>>,
}

impl Shape {
    fn is_shown(&self, time: f32) -> bool {
        self.shown.is_empty() || self.shown.iter().rfind(|key| key.0 <= time).is_some_and(|key| key.1 == 1.0)
    }

    /// Positions at the time of a key, by the rule of glTF.
    fn at(&self, time: f32) -> Vec<[f32; 3]> {
        let mut all = self.positions.clone();
        if let Some(key) = self.times.iter().position(|t| *t == time) {
            let weights = &self.weights[key * self.targets.len()..][..self.targets.len()];
            for (target, weight) in self.targets.iter().zip(weights) {
                for (p, delta) in all.iter_mut().zip(target) {
                    (0..3).for_each(|c| p[c] += weight * delta[c]);
                }
            }
        }
        all
    }
}

fn shapes(bytes: &[u8]) -> Vec<Shape> {
    let file = gltf::Gltf::from_slice(bytes).unwrap();
    let (document, blob) = (file.document, file.blob.unwrap());
    let floats =
        |accessor| gltf::accessor::Iter::<f32>::new(accessor, |_| Some(&blob[..])).unwrap().collect::<Vec<_>>();
    let mut shapes = Vec::new();
    let scene = document.default_scene().unwrap();
    let mut nodes: Vec<_> = scene.nodes().map(|node| (node, Vec::new())).collect();
    while !nodes.is_empty() {
        let (node, mut shown) = nodes.remove(0);
        let (mut times, mut weights) = (Vec::new(), Vec::new());
        for channel in document.animations().flat_map(|a| a.channels().collect::<Vec<_>>()) {
            if channel.target().node().index() != node.index() {
                continue;
            }
            let reader = channel.reader(|_| Some(&blob[..]));
            let inputs: Vec<f32> = reader.read_inputs().unwrap().collect();
            match reader.read_outputs().unwrap() {
                gltf::animation::util::ReadOutputs::Scales(scales) => {
                    assert_eq!(channel.sampler().interpolation(), gltf::animation::Interpolation::Step);
                    shown = inputs.into_iter().zip(scales.map(|s| s[0])).collect();
                }
                _ => (times, weights) = (inputs, floats(channel.sampler().output())),
            }
        }
        nodes.extend(node.children().map(|child| (child, shown.clone())));
        let Some(mesh) = node.mesh() else { continue };
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&blob[..]));
        let positions: Vec<_> = reader.read_positions().unwrap().collect();
        let targets = reader.read_morph_targets().map(|(p, n, _)| {
            let deltas: Vec<_> = p.unwrap().collect();
            assert_eq!((deltas.len(), n.unwrap().count()), (positions.len(), positions.len()));
            deltas
        });
        shapes.push(Shape {
            name: node.name().unwrap().into(),
            targets: targets.collect(),
            indices: reader.read_indices().unwrap().into_u32().collect(),
            uv: reader.read_tex_coords(0).map(|uv| uv.into_f32().collect()),
            positions,
            shown,
            times,
            weights,
        });
    }
    shapes
}

/// Compares each frame with the shapes that are shown then; corners of triangles to the rounding of one sum.
fn compare(bytes: &[u8], frames: &[Reconstruction]) {
    let shapes = shapes(bytes);
    for (k, surface) in frames.iter().enumerate() {
        let time = (k as f64 / 30.0) as f32;
        let shown: Vec<_> = shapes.iter().filter(|shape| shape.is_shown(time)).collect();
        assert_eq!(shown.len(), surface.pieces.len(), "frame {k}");
        for (shape, piece) in shown.iter().zip(&surface.pieces) {
            assert_eq!(shape.name, piece.name);
            let triangles = piece_triangles(surface, piece).as_flattened();
            let (at, expected) = (shape.at(time), triangles.iter().map(|v| surface.positions[*v as usize]));
            assert_eq!(shape.indices.len(), triangles.len());
            for (index, expected) in shape.indices.iter().zip(expected) {
                let found = at[*index as usize];
                assert!((0..3).all(|c| (found[c] - expected[c]).abs() <= 2.0 * f32::EPSILON), "{found:?} {expected:?}");
            }
            let uv = piece.uv.as_ref().map(|uv| uv.as_flattened());
            let found = shape.uv.as_ref().map(|uv| shape.indices.iter().map(|k| uv[*k as usize]).collect::<Vec<_>>());
            assert_eq!(found.as_deref(), uv);
        }
    }
}

#[test]
fn glb_frames_read_back() {
    for frames in [frames(1), frames(2), frames(6), cut(6, 3), cut(6, 5)] {
        for shown in [Shown::Targets, Shown::Meshes] {
            let bytes = glb(shown, &frames);
            compare(&bytes, &frames);
            assert_eq!(bytes, glb(shown, &frames));
        }
    }
}

#[test]
fn vertices_that_stay_are_not_in_targets() {
    let of = |frames: &[Reconstruction]| glb(Shown::Targets, frames).len();
    let (one, still) = (of(&frames(1)), of(&vec![sample(); 11]));
    assert!(still - one < 10 * 2 * 900, "{still} {one}");
    let text = String::from_utf8_lossy(&glb(Shown::Targets, &frames(2))).into_owned();
    assert!(text.contains("\"sparse\"") && text.contains("\"targetNames\":[\"0.033333335 s\"]"), "{text}");
    // Sparse indices of two and four bytes.
    for side in [20, 300] {
        let position = tube(side, 300, 0);
        let (width, height) = (side as usize, 300);
        let piece = PieceView { name: "a", width, height, first_particle: 0, position: &position, uv: None };
        let surface = reconstruct(&[piece]).unwrap();
        let mut moved = surface.clone();
        moved.positions.last_mut().unwrap()[0] += 1.0;
        let frames = [surface, moved];
        compare(&glb(Shown::Targets, &frames), &frames);
    }
}

#[test]
fn motions_that_are_too_large_are_refused_at_the_first_frame() {
    for frames in [MAX_TARGETS / 2 + 1, usize::MAX] {
        let refused = GltfMotion::new(Shown::Targets, frames).frame(&sample(), 0.0);
        assert!(matches!(refused, Err(Error::TooLarge { .. })), "{refused:?}");
    }
    let mut surface = sample();
    surface.pieces.truncate(1);
    let refused = GltfMotion::new(Shown::Targets, 40_000).frame(&surface, 0.0);
    assert!(refused.unwrap_err().to_string().contains("4294967295 bytes"));
    assert!(GltfMotion::new(Shown::Meshes, 40_000).frame(&surface, 0.0).is_ok());
}

#[test]
fn bad_frames_are_errors() {
    for writer in [
        || Box::new(GltfMotion::new(Shown::Targets, 9)) as Box<dyn MotionWriter>,
        || Box::new(UsdMotion::new("a", 30.0)),
    ] {
        let mut surface = sample();
        surface.positions[50][1] = f32::NAN;
        let error = writer().frame(&surface, 0.0).unwrap_err().to_string();
        assert!(error.contains("a \"b\"") && error.contains("vertex 50 is not finite in frame 0"), "{error}");
        surface = sample();
        surface.normals[0][0] = f32::INFINITY;
        assert!(writer().frame(&surface, 0.0).unwrap_err().to_string().contains("normal of vertex 0"));
        surface = sample();
        surface.normals.pop();
        assert!(matches!(writer().frame(&surface, 0.0), Err(Error::Internal(_))));
        assert!(writer().finish().unwrap_err().to_string().contains("at least one frame"));
    }
    let mut writer = GltfMotion::new(Shown::Targets, 9);
    writer.frame(&sample(), 1.0).unwrap();
    assert!(writer.frame(&sample(), 1.0).is_err());
    let far = |x: f32| {
        let mut surface = sample();
        surface.positions[0][0] = x;
        surface
    };
    let error = written(Box::new(GltfMotion::new(Shown::Targets, 2)), &[far(-3e38), far(3e38)]).unwrap_err();
    assert!(error.to_string().contains("--as meshes"), "{error}");
}

/// The numbers of an array of a USD file.
fn numbers(text: &str) -> Vec<f32> {
    let parts = text.split(|c: char| !"0123456789.-+e".contains(c)).filter(|part| !part.is_empty());
    parts.map(|part| part.parse().unwrap()).collect()
}

/// The values of an attribute of a mesh of a USD file by time code; 0 for one without samples.
fn attribute(text: &str, mesh: &str, attribute: &str) -> Vec<(usize, Vec<f32>)> {
    let text = text.split(&format!("def Mesh \"{mesh}\"")).nth(1).unwrap();
    if let Some(samples) = text.split(&format!("{attribute}.timeSamples = {{\n")).nth(1) {
        let lines = samples.lines().take_while(|line| line.trim() != "}");
        return lines
            .map(|line| line.trim().split_once(": ").unwrap())
            .map(|(k, v)| (k.parse().unwrap(), numbers(v)))
            .collect();
    }
    let line = text.lines().find_map(|line| line.trim().strip_prefix(attribute)?.strip_prefix(" = ")).unwrap();
    vec![(0, numbers(line))]
}

#[test]
fn usd_frames_read_back_bit_equal() {
    for frames in [frames(1), frames(3), cut(4, 2)] {
        let bytes = written(Box::new(UsdMotion::new("my scene", 24.0)), &frames).unwrap();
        assert_eq!(bytes, written(Box::new(UsdMotion::new("my scene", 24.0)), &frames).unwrap());
        let text = String::from_utf8(bytes).unwrap();
        for line in [
            "#usda 1.0",
            "    defaultPrim = \"my_scene\"",
            "    metersPerUnit = 1",
            "    startTimeCode = 1",
            "    timeCodesPerSecond = 24",
            "    upAxis = \"Y\"",
            "        displayName = \"a \\\"b\\\"\"",
        ] {
            assert!(text.lines().any(|l| l == line), "{line}: {text}");
        }
        assert!(text.contains(&format!("endTimeCode = {}\n", frames.len())));
        for (mesh, piece) in ["left", "a__b_"].into_iter().zip(0..) {
            let of = |name: &str| attribute(&text, mesh, name);
            let (indices, points, normals) = (of("faceVertexIndices"), of("points"), of("normals"));
            let (counts, extent) = (of("faceVertexCounts"), of("extent"));
            assert_eq!([points.len(), normals.len(), extent.len()], [frames.len(); 3]);
            for (k, surface) in frames.iter().enumerate() {
                let held =
                    |list: &[(usize, Vec<f32>)]| list.iter().rfind(|sample| sample.0 <= k + 1).unwrap().1.clone();
                let triangles = piece_triangles(surface, &surface.pieces[piece]);
                let (at, own) = (held(&indices), &points[k]);
                assert_eq!((own.0, held(&counts)), (k + 1, vec![3.0; triangles.len()]));
                for (list, values) in [(&own.1, &surface.positions), (&normals[k].1, &surface.normals)] {
                    let found: Vec<_> = at.iter().map(|i| &list[3 * *i as usize..][..3]).collect();
                    let expected: Vec<_> = triangles.as_flattened().iter().map(|v| &values[*v as usize][..]).collect();
                    assert_eq!(found, expected);
                }
                for c in 0..3 {
                    let along = || own.1.iter().skip(c).step_by(3).copied();
                    let found = [extent[k].1[c], extent[k].1[c + 3]];
                    assert_eq!(found, [along().reduce(f32::min).unwrap(), along().reduce(f32::max).unwrap()]);
                }
            }
        }
        let uv = &attribute(&text, "left", "primvars:st")[0].1;
        let expected = frames[0].pieces[0].uv.as_ref().unwrap().as_flattened().iter().flat_map(|[u, v]| [*u, 1.0 - v]);
        assert_eq!(*uv, expected.collect::<Vec<_>>());
    }
}

#[test]
fn a_piece_that_is_cut_away_stays_a_mesh_without_faces() {
    let mut all = frames(2);
    all[1].triangles.truncate(all[1].pieces[1].triangles.start);
    all[1].pieces[1].triangles.end = all[1].pieces[1].triangles.start;
    let text = String::from_utf8(written(Box::new(UsdMotion::new("a", 24.0)), &all).unwrap()).unwrap();
    let counts = attribute(&text, "a__b_", "faceVertexCounts");
    assert!(counts[0].1.len() > 10 && counts[1].1.is_empty() && !text.contains("inf"), "{text}");
    let shapes = shapes(&glb(Shown::Targets, &all));
    assert_eq!(shapes.iter().filter(|shape| shape.is_shown(0.04)).count(), 1);
}
