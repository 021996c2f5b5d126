use serde_json::json;

use super::*;

/// A document of one mesh with these primitives, whose vertices are those of the imported mesh in order.
struct Built {
    document: Document,
    placed: Vec<Placed>,
    trace: Trace,
}

/// Appends numbers of a kind (5121, 5123, 5125, 5126) with an accessor.
fn push(document: &mut Document, values: &[f64], (wide, kind): (usize, u64), more: Value) -> usize {
    let layout = Layout { start: 0, stride: 0, count: 0, components: wide, kind };
    document.bin.resize(document.bin.len().next_multiple_of(4), 0);
    let start = document.bin.len();
    document.bin.extend(values.iter().flat_map(|x| layout.bytes(*x)));
    let view = json!({"buffer": 0, "byteOffset": start, "byteLength": document.bin.len() - start});
    let name = if wide == 1 { "SCALAR".into() } else { format!("VEC{wide}") };
    let mut accessor = json!({
        "bufferView": document.json["bufferViews"].as_array().unwrap().len(), "componentType": kind, "count": values.len() / wide, "type": name
    });
    more.as_object().into_iter().flatten().for_each(|(k, v)| accessor[k] = v.clone());
    document.json["bufferViews"].as_array_mut().unwrap().push(view);
    let list = document.json["accessors"].as_array_mut().unwrap();
    list.push(accessor);
    list.len() - 1
}

fn empty() -> Built {
    let json = json!({"accessors": [], "bufferViews": [], "meshes": [{"primitives": []}], "nodes": [{"mesh": 0}]});
    Built {
        document: Document { json, bin: Vec::new(), vertices: Vec::new() },
        placed: Vec::new(),
        trace: Trace::default(),
    }
}

impl Built {
    fn add(&mut self, positions: &[[f64; 3]], triangles: &[[u32; 3]], is_cloth: bool, attributes: Value) {
        let flat: Vec<f64> = positions.iter().flatten().copied().collect();
        let indices: Vec<f64> = triangles.iter().flatten().map(|v| f64::from(*v)).collect();
        let mut primitive = json!({"attributes": attributes});
        primitive["attributes"]["POSITION"] =
            json!(push(&mut self.document, &flat, (3, 5126), json!({"min": [-9, -9, -9], "max": [9, 9, 9]})));
        primitive["indices"] = json!(push(&mut self.document, &indices, (1, 5123), json!({})));
        let list = self.document.json["meshes"][0]["primitives"].as_array_mut().unwrap();
        list.push(primitive);
        let first = self.trace.positions.len() as u32;
        let imported = (first..first + positions.len() as u32).collect();
        let vertices = (0..positions.len() as u32).collect();
        let primitive = list.len() - 1;
        self.placed.push(Placed { node: Some(0), mesh: 0, primitive, instance: None, vertices, imported });
        self.trace.positions.extend(positions);
        self.trace.triangles.extend(triangles.iter().map(|t| t.map(|v| v + first)));
        self.trace.is_cloth.extend(positions.iter().map(|_| is_cloth));
    }

    fn divide(&mut self, longest: f64) -> Option<Divided> {
        subdivide(&mut self.document, &mut self.placed, &mut self.trace, (longest, 100_000))
    }

    fn read(&self, primitive: usize, name: &str) -> (Layout, Vec<f64>) {
        let of = &self.document.json["meshes"][0]["primitives"][primitive];
        let accessor = if name == "indices" { &of["indices"] } else { &of["attributes"][name] };
        let layout = Layout::of(&self.document.json, &self.document.bin, accessor.as_u64().unwrap()).unwrap();
        (layout, layout.numbers(&self.document.bin))
    }

    /// The edges of a primitive by the positions of their ends, each as often as triangles have it.
    fn edges(&self, primitives: &[usize]) -> HashMap<[[u64; 3]; 2], usize> {
        let mut edges = HashMap::new();
        for p in primitives {
            let (at, order) = (self.read(*p, "POSITION").1, self.read(*p, "indices").1);
            for t in order.chunks(3) {
                for k in 0..3 {
                    let corner = |v: f64| place([0, 1, 2].map(|c| at[3 * v as usize + c]));
                    let mut key = [corner(t[k]), corner(t[(k + 1) % 3])];
                    key.sort_unstable();
                    *edges.entry(key).or_insert(0) += 1;
                }
            }
        }
        edges
    }
}

const QUAD: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn a_quad_is_divided_and_keeps_its_vertices() {
    let mut built = empty();
    built.add(&QUAD, &[[0, 1, 2], [0, 2, 3]], true, json!({}));
    let divided = built.divide(0.3).unwrap();
    assert_eq!(divided.before, 2);
    let (at, order) = (built.read(0, "POSITION").1, built.read(0, "indices").1);
    assert_eq!(at[..12], *QUAD.as_flattened());
    assert_eq!(order.len(), 3 * divided.after);
    let long =
        |a: f64, b: f64| (0..3).map(|c| (at[3 * a as usize + c] - at[3 * b as usize + c]).powi(2)).sum::<f64>().sqrt();
    assert!(order.chunks(3).all(|t| (0..3).all(|k| long(t[k], t[(k + 1) % 3]) <= 0.3)));
    // All triangles face the same way, and cover the quad once.
    let area = |t: &[f64]| {
        let p = |v: f64, c: usize| at[3 * v as usize + c];
        let side = |k: usize, c: usize| p(t[k], c) - p(t[0], c);
        0.5 * (side(1, 0) * side(2, 1) - side(1, 1) * side(2, 0))
    };
    assert!(order.chunks(3).all(|t| area(t) > 0.0));
    assert!((order.chunks(3).map(area).sum::<f64>() - 1.0).abs() < 1e-6);
    let once = built.edges(&[0]).values().filter(|n| **n == 1).count();
    assert_eq!(once, 16, "four sides in four parts each");
    // Every new vertex is one of the imported mesh, where it is.
    let Placed { vertices, imported, .. } = &built.placed[0];
    assert_eq!(vertices.len(), at.len() / 3);
    for (v, i) in vertices.iter().zip(imported) {
        let own = built.trace.positions[*i as usize];
        assert!((0..3).all(|c| (at[3 * *v as usize + c] - own[c]).abs() < 1e-6));
    }
}

#[test]
fn primitives_that_share_an_edge_have_it_halved_alike() {
    let mut built = empty();
    built.add(&QUAD[..3], &[[0, 1, 2]], true, json!({}));
    built.add(&[QUAD[2], QUAD[3], QUAD[0]], &[[0, 1, 2]], true, json!({}));
    built.divide(0.4).unwrap();
    let border = |list: &[usize]| built.edges(list).values().filter(|n| **n == 1).count();
    // Both together have no border along the diagonal.
    assert_eq!(border(&[0, 1]), 16);
    assert!(border(&[0]) > 8 && border(&[1]) > 8);
}

#[test]
fn edges_shared_with_what_is_not_cloth_stay_whole() {
    let mut built = empty();
    built.add(&QUAD[..3], &[[0, 1, 2]], true, json!({}));
    built.add(&[QUAD[2], QUAD[3], QUAD[0]], &[[0, 1, 2]], false, json!({}));
    built.divide(0.4).unwrap();
    let mut diagonal = [place(QUAD[0]), place(QUAD[2])];
    diagonal.sort_unstable();
    assert_eq!(built.edges(&[0, 1])[&diagonal], 2);
    assert_eq!(built.read(1, "indices").1.len(), 3);
}

#[test]
fn joints_and_normals_are_means() {
    let mut built = empty();
    let document = &mut built.document;
    // Whole weights, of which those of the first two corners share one joint.
    let joints = push(document, &[1., 2., 3., 4., 5., 6., 7., 1., 9., 0., 0., 0.], (4, 5121), json!({}));
    let weights = [100., 80., 50., 25., 90., 70., 60., 35., 255., 0., 0., 0.];
    let weights = push(document, &weights, (4, 5121), json!({"normalized": true}));
    let normals =
        push(document, &[0., 0., 1., 1., 0., 0., 0., 1., 0.], (3, 5126), json!({"max": [1, 1, 1], "min": [0, 0, 0]}));
    let uv = push(document, &[0., 0., 65535., 0., 0., 101.], (2, 5123), json!({"normalized": true}));
    let attributes = json!({"JOINTS_0": joints, "WEIGHTS_0": weights, "NORMAL": normals, "TEXCOORD_0": uv});
    built.add(&QUAD[..3], &[[0, 1, 2]], true, attributes);
    assert_eq!(built.divide(0.9).unwrap().after, 4);
    let (at, normals) = (built.read(0, "POSITION").1, built.read(0, "NORMAL").1);
    let middle = |x: f64, y: f64| (0..at.len() / 3).find(|v| at[3 * v] == x && at[3 * v + 1] == y).unwrap();
    let bottom = middle(0.5, 0.0);
    assert!(
        (normals[3 * bottom] - 0.5f64.sqrt()).abs() < 1e-6 && (normals[3 * bottom + 2] - 0.5f64.sqrt()).abs() < 1e-6
    );
    let of = |name: &str, v: usize| built.read(0, name).1[4 * v..4 * v + 4].to_vec();
    // Joint 1 has 100 + 35, joint 5 has 90, joint 2 has 80, joint 6 has 70 of the two wholes.
    assert_eq!(of("JOINTS_0", bottom), [1.0, 5.0, 2.0, 6.0]);
    let whole: f64 = of("WEIGHTS_0", bottom).iter().sum();
    assert_eq!(whole, 255.0);
    assert_eq!(of("WEIGHTS_0", bottom)[1], (90.0 / 375.0f64 * 255.0).round());
    let (layout, uv) = built.read(0, "TEXCOORD_0");
    assert_eq!((uv[2 * bottom], layout.stride), (32768.0, 4));
    let accessor = built.document.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"].as_u64().unwrap();
    assert!(built.document.json["accessors"][accessor as usize].get("max").is_none());
}

#[test]
fn what_cannot_be_divided_stays_and_holds_its_neighbours() {
    let mut built = empty();
    built.add(&QUAD[..3], &[[0, 1, 2]], true, json!({}));
    built.add(&[QUAD[2], QUAD[3], QUAD[0]], &[[0, 1, 2]], true, json!({}));
    built.document.json["meshes"][0]["primitives"][1]["mode"] = json!(5);
    built.divide(0.4).unwrap();
    let mut diagonal = [place(QUAD[0]), place(QUAD[2])];
    diagonal.sort_unstable();
    assert_eq!(built.edges(&[0, 1])[&diagonal], 2);
    // A mesh that two nodes place.
    let mut built = empty();
    built.add(&QUAD, &[[0, 1, 2], [0, 2, 3]], true, json!({}));
    built.document.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0}]);
    assert_eq!(built.divide(0.4), None);
    // Indices beyond the vertices, and no limit that anything exceeds.
    let mut built = empty();
    built.add(&QUAD, &[[0, 1, 9]], true, json!({}));
    assert_eq!(built.divide(0.4), None);
    let mut built = empty();
    built.add(&QUAD, &[[0, 1, 2]], true, json!({}));
    assert_eq!(built.divide(2.0), None);
}

#[test]
fn the_number_of_triangles_is_bounded() {
    let mut built = empty();
    let far: Vec<[f64; 3]> = QUAD.iter().map(|p| p.map(|x| 1e6 * x)).collect();
    built.add(&far, &[[0, 1, 2], [0, 2, 3]], true, json!({}));
    let divided = subdivide(&mut built.document, &mut built.placed, &mut built.trace, (0.01, 500)).unwrap();
    assert!(divided.after > 500 && divided.after <= 4 * 500 * 4, "{divided:?}");
}
