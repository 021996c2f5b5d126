//! Numbers of a document that are not finite: no program can draw them, and bounds of boxes are lost with them.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::layout::{FLOAT, Layout, TRIANGLES};

/// Gives vertices whose position is not finite the position of another vertex of their primitive, collapses the triangles that have such a
/// vertex to a point, and replaces other numbers of vertices that are not finite by 0. Returns how many positions and how many other attributes of vertices were not finite.
///
/// The import leaves these triangles out of the cloth and reports them.
pub(super) fn make_finite(json: &mut Value, bin: &mut [u8]) -> [usize; 2] {
    let mut broken: BTreeMap<u64, BTreeSet<usize>> = BTreeMap::new();
    let mut counts = [0; 2];
    let primitives: Vec<Value> = json["meshes"].as_array().into_iter().flatten().flat_map(primitives).collect();
    for primitive in &primitives {
        let position = primitive["attributes"]["POSITION"].as_u64();
        let attributes = primitive["attributes"].as_object().into_iter().flatten();
        for accessor in attributes.filter_map(|(_, a)| a.as_u64()) {
            if broken.contains_key(&accessor) {
                continue;
            }
            let Some(layout) = Layout::of(json, bin, accessor).filter(|l| l.kind == FLOAT) else { continue };
            let is_position = Some(accessor) == position;
            let found = mend(bin, layout, is_position);
            counts[usize::from(!is_position)] += found.len();
            if is_position && !found.is_empty() {
                bound(json, bin, accessor, layout);
            }
            broken.insert(accessor, found);
        }
    }
    let none = BTreeSet::new();
    for primitive in primitives.iter().filter(|p| p["mode"].as_u64().unwrap_or(TRIANGLES) == TRIANGLES) {
        let found = primitive["attributes"]["POSITION"].as_u64().and_then(|a| broken.get(&a)).unwrap_or(&none);
        match primitive["indices"].as_u64() {
            Some(accessor) => {
                Layout::of(json, bin, accessor).into_iter().for_each(|layout| collapse(bin, layout, found));
            }
            None => {
                let layout = primitive["attributes"]["POSITION"].as_u64().and_then(|a| Layout::of(json, bin, a));
                layout.into_iter().for_each(|layout| gather(bin, layout, found));
            }
        }
    }
    counts
}

fn primitives(mesh: &Value) -> Vec<Value> {
    mesh["primitives"].as_array().cloned().unwrap_or_default()
}

/// Makes all elements finite; returns those that were not.
fn mend(bin: &mut [u8], layout: Layout, is_position: bool) -> BTreeSet<usize> {
    let broken: BTreeSet<usize> = (0..layout.count).filter(|n| !layout.is_finite(bin, *n)).collect();
    let whole = (0..layout.count).find(|n| !broken.contains(n)).filter(|_| is_position);
    let other = whole.map_or(vec![0.0; layout.components], |n| layout.floats(bin, n));
    for n in &broken {
        let own: Vec<f32> = layout.floats(bin, *n).into_iter().map(|v| if v.is_finite() { v } else { 0.0 }).collect();
        layout.put(bin, *n, if is_position { &other } else { &own });
    }
    broken
}

/// Collapses triangles with a vertex that was not finite.
fn collapse(bin: &mut [u8], layout: Layout, broken: &BTreeSet<usize>) {
    let size = match layout.kind {
        5121 => 1,
        5123 => 2,
        5125 => 4,
        _ => return,
    };
    if broken.is_empty() || layout.stride != size {
        return;
    }
    let all = &mut bin[layout.start..layout.start + layout.count * size];
    for triangle in all.chunks_exact_mut(3 * size) {
        let index = |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, b| sum << 8 | usize::from(*b));
        let first = triangle.chunks(size).find(|i| !broken.contains(&index(i))).unwrap_or(&triangle[..size]).to_vec();
        if triangle.chunks(size).any(|i| broken.contains(&index(i))) {
            triangle.chunks_mut(size).for_each(|i| i.copy_from_slice(&first));
        }
    }
}

/// Collapses triangles of consecutive vertices, of which one was not finite.
fn gather(bin: &mut [u8], layout: Layout, broken: &BTreeSet<usize>) {
    for first in broken.iter().map(|n| n - n % 3).filter(|first| first + 3 <= layout.count) {
        let whole = (first..first + 3).find(|n| !broken.contains(n)).unwrap_or(first);
        let at = layout.floats(bin, whole);
        (first..first + 3).for_each(|n| layout.put(bin, n, &at));
    }
}

/// Writes the bounds of positions that have changed.
fn bound(json: &mut Value, bin: &[u8], accessor: u64, layout: Layout) {
    let (mut low, mut high) = (vec![f32::INFINITY; layout.components], vec![f32::NEG_INFINITY; layout.components]);
    for n in 0..layout.count {
        for (c, v) in layout.floats(bin, n).into_iter().enumerate() {
            (low[c], high[c]) = (low[c].min(v), high[c].max(v));
        }
    }
    let accessor = &mut json["accessors"][accessor as usize];
    (accessor["min"], accessor["max"]) = (json!(low), json!(high));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(indices: &[u16], positions: &[[f32; 3]]) -> (Value, Vec<u8>) {
        let mut bin: Vec<u8> = positions.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let at = bin.len();
        bin.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
        let json = json!({
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3", "min": [9, 9, 9], "max": [9, 9, 9]},
                {"bufferView": 1, "componentType": 5123, "count": indices.len(), "type": "SCALAR"},
            ],
            "bufferViews": [{"buffer": 0, "byteLength": at}, {"buffer": 0, "byteOffset": at, "byteLength": bin.len() - at}],
        });
        (json, bin)
    }

    #[test]
    fn a_vertex_without_a_position_takes_its_triangles_with_it() {
        let positions =
            [[f32::NAN, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, f32::INFINITY, 0.0]];
        let (mut json, mut bin) = document(&[0, 1, 2, 1, 2, 3, 3, 4, 0], &positions);
        assert_eq!(make_finite(&mut json, &mut bin), [2, 0]);
        let read = |n: usize| Layout::of(&json, &bin, 0).unwrap().floats(&bin, n);
        assert_eq!([read(0), read(1), read(4)], [[1.0, 2.0, 3.0]; 3]);
        let at = Layout::of(&json, &bin, 1).unwrap().start;
        let indices: Vec<u16> = bin[at..].as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect();
        assert_eq!(indices, [1, 1, 1, 1, 2, 3, 3, 3, 3]);
        assert_eq!(
            (json["accessors"][0]["min"].clone(), json["accessors"][0]["max"].clone()),
            (json!([0.0, 0.0, 0.0]), json!([1.0, 2.0, 3.0]))
        );
    }

    #[test]
    fn triangles_of_consecutive_vertices_collapse_too() {
        let positions = [[1.0, 2.0, 3.0], [f32::NAN; 3], [0.0; 3], [7.0; 3], [8.0; 3], [9.0; 3]];
        let (mut json, mut bin) = document(&[], &positions);
        json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
        assert_eq!(make_finite(&mut json, &mut bin), [1, 0]);
        let layout = Layout::of(&json, &bin, 0).unwrap();
        let read: Vec<_> = (0..6).map(|n| layout.floats(&bin, n)[0]).collect();
        assert_eq!(read, [1.0, 1.0, 1.0, 7.0, 8.0, 9.0]);
    }

    #[test]
    fn other_attributes_are_counted_apart_and_keep_what_is_finite() {
        let (mut json, mut bin) = document(&[0, 1, 2], &[[0.0; 3], [1.0; 3], [5.0, f32::NAN, 6.0]]);
        // The same numbers as normals: positions come from elsewhere.
        json["meshes"][0]["primitives"][0]["attributes"] = json!({"NORMAL": 0});
        assert_eq!(make_finite(&mut json, &mut bin), [0, 1]);
        assert_eq!(Layout::of(&json, &bin, 0).unwrap().floats(&bin, 2), [5.0, 0.0, 6.0]);
    }

    #[test]
    fn a_finite_document_stays_as_it_is() {
        let (mut json, mut bin) = document(&[0, 1, 2], &[[0.0; 3], [1.0; 3], [2.0; 3]]);
        let before = (json.clone(), bin.clone());
        assert_eq!(make_finite(&mut json, &mut bin), [0; 2]);
        assert_eq!((json, bin), before);
    }
}
