//! Compressed files of moving surfaces, read back.

use gimage::Error;
use gimage::export::motion::{Compression, GltfMotion, MotionWriter, Part, Shown};
use gimage::import::{ImportOptions, import};
use gimage::mesh::Semantic;
use gimage::options::BuildOptions;
use gimage::pipeline::build;
use gimage::progress::Quiet;
use gimage::reconstruct::{ReconstructedPiece, Reconstruction};
use gimage_bundle::RenderFile;
use serde_json::Value;

const SIDE: u32 = 17;

/// A sheet 1.6 m wide, with a wave that runs over it; its texture coordinates are the shares of its sides.
fn wave(frame: usize) -> Reconstruction {
    let at = |k: u32| [0.1 * (k % SIDE) as f32 - 0.8, 0.1 * (k / SIDE) as f32];
    let slope = |x: f32| (3.0 * x + 0.2 * frame as f32).sin_cos();
    let quad = |k: u32| [[k, k + SIDE, k + 1], [k + 1, k + SIDE, k + SIDE + 1]];
    let cells = (0..SIDE * (SIDE - 1)).filter(|k| k % SIDE < SIDE - 1);
    let triangles: Vec<[u32; 3]> = cells.flat_map(quad).collect();
    let place = |k| {
        let [x, z] = at(k);
        [x, 0.1 * slope(x).0, z]
    };
    let normal = |k| {
        let tilt = 0.3 * slope(at(k)[0]).1;
        let length = (1.0 + tilt * tilt).sqrt();
        [-tilt / length, 1.0 / length, 0.0]
    };
    let uv = |k| [(at(k)[0] + 0.8) / 1.6, at(k)[1] / 1.6];
    let uv = triangles.iter().map(|t| t.map(uv)).collect();
    let all = 0..SIDE * SIDE;
    Reconstruction {
        positions: all.clone().map(place).collect(),
        normals: all.map(normal).collect(),
        pieces: vec![ReconstructedPiece { name: "wave".into(), triangles: 0..triangles.len(), uv: Some(uv) }],
        triangles,
    }
}

/// The same in tatters: parts that touch at a vertex alone, an edge with three triangles, a triangle twice, and one without an area.
fn tattered() -> Reconstruction {
    let mut surface = wave(3);
    let mut triangles: Vec<[u32; 3]> = surface.triangles.iter().step_by(3).copied().collect();
    let [a, b, _] = triangles[0];
    triangles.extend([[b, a, 150], [b, a, 200], triangles[7], [40, 40, 41]]);
    surface.pieces = vec![ReconstructedPiece { name: "tatters".into(), triangles: 0..triangles.len(), uv: None }];
    surface.triangles = triangles;
    surface
}

fn written(shown: Shown, compression: Compression, frames: &[Reconstruction]) -> Vec<u8> {
    let mut writer = Box::new(GltfMotion::new(shown, frames.len()).compressed(compression).unwrap());
    let mut bytes = Vec::new();
    for (k, surface) in frames.iter().enumerate() {
        bytes.extend(writer.frame(surface, k as f64 / 30.0).unwrap());
    }
    let part = |part| match part {
        Part::Bytes(list) => list,
        Part::Written(range) => bytes[range.start as usize..range.end as usize].to_vec(),
    };
    writer.finish().unwrap().into_iter().flat_map(part).collect()
}

fn gap(a: [f64; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|c| (a[c] - f64::from(b[c])).abs()).fold(0.0, f64::max)
}

/// The vertex of a surface at a place.
fn vertex(surface: &Reconstruction, at: [f64; 3], within: f64) -> u32 {
    let near: Vec<u32> =
        (0..).zip(&surface.positions).filter(|(_, p)| gap(at, **p) <= within).map(|(k, _)| k).collect();
    assert_eq!(near.len(), 1, "{at:?} {near:?}");
    near[0]
}

/// Triangles with their first corner the least, in order, without those of equal corners.
fn ordered(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let turned = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or_default();
    let mut all: Vec<_> = triangles.filter(|[a, b, c]| a != b && b != c && c != a).map(turned).collect();
    all.sort();
    all
}

#[test]
fn the_importer_reads_compressed_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    for surface in [wave(0), tattered()] {
        let plain = written(Shown::Meshes, Compression::None, std::slice::from_ref(&surface)).len();
        // 1.6 m at 16 bits, and a 2^-17th of 1.6 m: both by half a step and the rounding of floats.
        for (compression, extension, within) in [
            (Compression::Draco, "KHR_draco_mesh_compression", 1.6 / 65_535.0),
            (Compression::Meshopt, "EXT_meshopt_compression", 1.6 / 131_072.0),
        ] {
            let bytes = written(Shown::Meshes, compression, std::slice::from_ref(&surface));
            assert!(bytes.len() < plain * 3 / 4, "{extension}: {} bytes of {plain}", bytes.len());
            assert!(String::from_utf8_lossy(&bytes).contains(extension));
            assert_eq!(bytes, written(Shown::Meshes, compression, std::slice::from_ref(&surface)));
            std::fs::write(&path, &bytes).unwrap();
            let mesh = import(&path, &ImportOptions::default()).unwrap().mesh;
            let corner = |v: u32| vertex(&surface, mesh.positions[v as usize], within);
            let found = ordered(mesh.triangles.iter().map(|t| t.map(corner)));
            assert_eq!(found, ordered(surface.triangles.iter().copied()), "{extension}");
            for channel in &mesh.channels {
                for (t, corners) in mesh.triangles.iter().enumerate() {
                    for (c, v) in corners.iter().enumerate() {
                        let (k, value) = (corner(*v) as usize, channel.at(t, c).unwrap());
                        let p = surface.positions[k];
                        let (expected, within) = match channel.semantic {
                            Semantic::Normal => (surface.normals[k].to_vec(), 1e-3),
                            Semantic::TexCoord(0) => (vec![(p[0] + 0.8) / 1.6, p[2] / 1.6], 2e-5),
                            _ => continue,
                        };
                        let far = value.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                        assert!(far < within, "{extension}, {:?}: {value:?} {expected:?}", channel.semantic);
                    }
                }
            }
            let sets = mesh.channels.iter().filter(|c| c.semantic == Semantic::TexCoord(0)).count();
            assert_eq!(sets, usize::from(surface.pieces[0].uv.is_some()));
        }
    }
}

#[test]
fn draco_streams_whose_indices_have_no_accessor_have_a_render_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let bytes = written(Shown::Meshes, Compression::Draco, &[wave(0)]);
    let glb = gltf::Glb::from_slice(&bytes).unwrap();
    let mut root: Value = serde_json::from_slice(&glb.json).unwrap();
    root["meshes"][0]["primitives"][0]["indices"] = 9999.into();
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let changed = gltf::Glb { json: text.into(), ..glb };
    std::fs::write(&path, changed.to_vec().unwrap()).unwrap();
    let built = build(&path, &BuildOptions::default(), &Quiet).unwrap();
    let file = built.bundle.render.as_ref().map(|bytes| RenderFile::parse(bytes).unwrap()).unwrap();
    assert_eq!(file.primitives().unwrap()[0].indices.len(), 6 * 16 * 16);
}

/// A file whose views are unpacked.
struct Unpacked {
    root: Value,
    views: Vec<Vec<u8>>,
}

impl Unpacked {
    fn new(bytes: &[u8]) -> Self {
        let glb = gltf::Glb::from_slice(bytes).unwrap();
        let root: Value = serde_json::from_slice(&glb.json).unwrap();
        let blob = glb.bin.unwrap();
        let part = |of: &Value| {
            let number = |key: &str| of[key].as_u64().unwrap() as usize;
            assert_eq!(number("buffer"), 0);
            &blob[number("byteOffset")..][..number("byteLength")]
        };
        let view = |view: &Value| {
            let packed = &view["extensions"]["EXT_meshopt_compression"];
            if packed.is_null() {
                return part(view).to_vec();
            }
            let [count, stride] = ["count", "byteStride"].map(|key| packed[key].as_u64().unwrap() as usize);
            assert_eq!(view["byteLength"].as_u64(), Some((count * stride) as u64));
            let is_rounded = packed["filter"].as_str() == Some("EXPONENTIAL");
            match (packed["mode"].as_str().unwrap(), stride) {
                ("ATTRIBUTES", 4) => words::<1>(part(packed), count, is_rounded),
                ("ATTRIBUTES", 8) => words::<2>(part(packed), count, is_rounded),
                ("ATTRIBUTES", 12) => words::<3>(part(packed), count, is_rounded),
                ("TRIANGLES", 4) => {
                    let all = meshopt::decode_index_buffer::<u32>(part(packed), count).unwrap();
                    all.iter().flat_map(|k| k.to_le_bytes()).collect()
                }
                ("INDICES", 2) => {
                    let all = meshopt::decode_index_sequence::<u16>(part(packed), count).unwrap();
                    all.iter().flat_map(|k| k.to_le_bytes()).collect()
                }
                other => panic!("{other:?}"),
            }
        };
        let views = root["bufferViews"].as_array().unwrap().iter().map(view).collect();
        Unpacked { root, views }
    }

    fn view<const N: usize>(&self, of: &Value) -> Vec<[f32; N]> {
        let words = self.views[of["bufferView"].as_u64().unwrap() as usize].as_chunks::<4>().0;
        let floats: Vec<f32> = words.iter().map(|b| f32::from_le_bytes(*b)).collect();
        floats.as_chunks().0.to_vec()
    }

    /// The vectors of an accessor, within the bounds that it states.
    fn vectors(&self, accessor: &Value) -> Vec<[f32; 3]> {
        let of = &self.root["accessors"][accessor.as_u64().unwrap() as usize];
        let nothing = || vec![[0.0; 3]; of["count"].as_u64().unwrap() as usize];
        let mut all = if of["bufferView"].is_null() { nothing() } else { self.view(of) };
        let sparse = &of["sparse"];
        if !sparse.is_null() {
            let places = &self.views[sparse["indices"]["bufferView"].as_u64().unwrap() as usize];
            let places: Vec<usize> = match sparse["indices"]["componentType"].as_u64() {
                Some(5121) => places.iter().map(|k| usize::from(*k)).collect(),
                _ => places.as_chunks().0.iter().map(|b| usize::from(u16::from_le_bytes(*b))).collect(),
            };
            places.into_iter().zip(self.view(&sparse["values"])).for_each(|(k, value)| all[k] = value);
        }
        for (key, side) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
            for c in (0..3).filter(|_| of[key].is_array()) {
                let limit = all.iter().map(|v| v[c]).reduce(side);
                assert_eq!(of[key][c].as_f64().map(|x| x as f32), limit, "{key} of accessor {accessor}");
            }
        }
        all
    }
}

fn words<const N: usize>(data: &[u8], count: usize, is_rounded: bool) -> Vec<u8>
where
    [u32; N]: Default,
{
    let mut all: Vec<[u32; N]> = meshopt::decode_vertex_buffer(data, count).unwrap();
    if is_rounded {
        meshopt::decode_filter_exp(&mut all);
    }
    all.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn compressed_targets_are_the_motion() {
    let running: Vec<_> = (0..4).map(wave).collect();
    // Most vertices stay: sparse targets, which have indices of one byte or two.
    let some = |last: usize| {
        let mut all = vec![wave(0); 3];
        for (frame, surface) in all.iter_mut().enumerate() {
            surface.positions[..last].iter_mut().step_by(3).for_each(|p| p[1] += 0.3 * frame as f32);
        }
        all
    };
    for frames in [running, some(60), some(289)] {
        let bytes = written(Shown::Targets, Compression::Meshopt, &frames);
        let plain = written(Shown::Targets, Compression::None, &frames).len();
        assert!(bytes.len() < plain, "{} bytes of {plain}", bytes.len());
        let file = Unpacked::new(&bytes);
        let primitive = &file.root["meshes"][0]["primitives"][0];
        let base = file.vectors(&primitive["attributes"]["POSITION"]);
        let targets: Vec<_> =
            primitive["targets"].as_array().unwrap().iter().map(|t| file.vectors(&t["POSITION"])).collect();
        assert_eq!(targets.len(), frames.len() - 1);
        let at = |k: usize, v: usize| {
            [0, 1, 2].map(|c| f64::from(base[v][c]) + targets.get(k).map_or(0.0, |t| f64::from(t[v][c])))
        };
        let order: Vec<u32> = (0..base.len()).map(|v| vertex(&frames[0], at(usize::MAX, v), 1.6 / 131_072.0)).collect();
        for (frame, surface) in frames.iter().enumerate() {
            let far = |(v, k): (usize, &u32)| gap(at(frame.wrapping_sub(1), v), surface.positions[*k as usize]);
            let far = order.iter().enumerate().map(far).fold(0.0, f64::max);
            assert!(far < (1.6 + 0.6) / 131_072.0, "frame {frame}: {far} m");
        }
        let accessor = primitive["indices"].as_u64().unwrap() as usize;
        let view = file.root["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        let corners: Vec<u32> =
            file.views[view].as_chunks().0.iter().map(|b| order[u32::from_le_bytes(*b) as usize]).collect();
        let found = ordered(corners.as_chunks::<3>().0.iter().copied());
        assert_eq!(found, ordered(frames[0].triangles.iter().copied()));
    }
}

#[test]
fn draco_refuses_targets() {
    let refused = GltfMotion::new(Shown::Targets, 2).compressed(Compression::Draco);
    assert!(matches!(refused, Err(Error::Option { option, .. }) if option == "compress"));
}
