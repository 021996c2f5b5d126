//! Vertices in the middle of edges, and their attributes: means of those of both ends.

use std::collections::{BTreeMap, HashMap};

use serde_json::{Value, json};

use super::Document;
use super::attach::push;
use super::layout::{FLOAT, Layout};
use crate::base::joints::strongest;

/// New vertices, numbered after those of the source.
pub(super) struct Halves {
    first: u32,
    ends: Vec<[u32; 2]>,
    number: HashMap<[u32; 2], u32>,
}

/// The number of vertices, if all attributes can be read, and have the same number.
pub(super) fn is_readable(document: &Document, attributes: &Value, targets: &Value) -> Option<usize> {
    let lists = targets.as_array().into_iter().flatten().chain([attributes]);
    let mut counts = lists.flat_map(|list| list.as_object().into_iter().flatten()).map(|(_, accessor)| {
        let layout = Layout::of(&document.json, &document.bin, accessor.as_u64()?)?;
        Some(layout.count)
    });
    let first = counts.next()??;
    counts.all(|count| count == Some(first)).then_some(first).filter(|n| u32::try_from(*n).is_ok())
}

impl Halves {
    pub fn new(count: usize) -> Self {
        Halves { first: count as u32, ends: Vec::new(), number: HashMap::new() }
    }

    /// New vertices.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// The vertex in the middle of an edge.
    pub fn of(&mut self, [a, b]: [u32; 2]) -> u32 {
        let pair = [a.min(b), a.max(b)];
        let next = self.first + self.ends.len() as u32;
        let number = *self.number.entry(pair).or_insert(next);
        if number == next {
            self.ends.push(pair);
        }
        number
    }

    /// Appends the attributes of all vertices to the document; returns the lists of their accessors.
    pub fn write(&self, document: &mut Document, attributes: &Value, targets: &Value) -> (Value, Value) {
        let joints = self.joints(document, attributes);
        let mut list = |of: &Value, is_target: bool| {
            let mut out = json!({});
            for (name, accessor) in of.as_object().into_iter().flatten() {
                let Some(accessor) = accessor.as_u64() else { continue };
                let Some(layout) = Layout::of(&document.json, &document.bin, accessor) else { continue };
                let values = match joints.get(name).filter(|_| !is_target) {
                    Some(values) => values.clone(),
                    None => self.means(layout.numbers(&document.bin), layout, (name, is_target)),
                };
                out[name] = json!(write_like(document, (name, accessor), layout, &values));
            }
            out
        };
        let own = list(attributes, false);
        let targets = targets.as_array().map_or(Value::Null, |all| all.iter().map(|of| list(of, true)).collect());
        (own, targets)
    }

    /// The numbers of an attribute, with those of the new vertices.
    fn means(&self, mut values: Vec<f64>, layout: Layout, (name, is_target): (&str, bool)) -> Vec<f64> {
        let wide = layout.components;
        for &[a, b] in &self.ends {
            let at = |v: u32, c: usize| values[v as usize * wide + c];
            let mut mean: Vec<f64> = (0..wide).map(|c| 0.5 * (at(a, c) + at(b, c))).collect();
            if !is_target && matches!(name, "NORMAL" | "TANGENT") && wide >= 3 {
                let long = mean[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
                let most =
                    if layout.kind == FLOAT { 1.0 } else { f64::from(i32::pow(2, 8 * layout.size() as u32 - 1) - 1) };
                // Two opposite directions have no mean.
                (0..3).for_each(|c| mean[c] = if long > 1e-6 { mean[c] / long * most } else { at(a, c) });
                if wide == 4 {
                    mean[3] = at(a, 3);
                }
            }
            values.extend(mean);
        }
        values
    }

    /// The joints and weights of all vertices, by the names of their attributes: the heaviest of both ends.
    fn joints(&self, document: &Document, attributes: &Value) -> HashMap<String, Vec<f64>> {
        let read = |name: String| {
            let layout = Layout::of(&document.json, &document.bin, attributes.get(&name)?.as_u64()?)?;
            (layout.components == 4).then(|| (name, layout, layout.numbers(&document.bin)))
        };
        let sets = (0..).map_while(|n| Some([read(format!("JOINTS_{n}"))?, read(format!("WEIGHTS_{n}"))?]));
        let mut sets: Vec<_> = sets.collect();
        for &[a, b] in &self.ends {
            let of = |v: u32| {
                sets.iter().flat_map(move |[joints, weights]| {
                    let own = 4 * v as usize..4 * v as usize + 4;
                    let most = whole(weights.1);
                    joints.2[own.clone()].iter().zip(&weights.2[own]).map(move |(j, w)| (*j, w / most))
                })
            };
            let merged = merged(of(a).chain(of(b)).collect::<Vec<_>>().into_iter(), 4 * sets.len());
            for (n, [joints, weights]) in sets.iter_mut().enumerate() {
                let most = whole(weights.1);
                joints.2.extend(merged[4 * n..4 * n + 4].iter().map(|x| x.0));
                let mut own: Vec<f64> = merged[4 * n..4 * n + 4].iter().map(|x| x.1 * most).collect();
                if weights.1.kind != FLOAT {
                    own.iter_mut().for_each(|w| *w = w.round());
                }
                weights.2.extend(own);
            }
            // Whole numbers sum to one exactly: the heaviest takes what rounding has left.
            if let Some([_, weights]) = sets.first().filter(|s| s[1].1.kind != FLOAT) {
                let most = whole(weights.1);
                let last = |w: &Vec<f64>| w[w.len() - 4..].iter().sum::<f64>();
                let sum: f64 = sets.iter().map(|s| last(&s[1].2)).sum();
                let heaviest = sets[0][1].2.len() - 4;
                sets[0][1].2[heaviest] += most - sum;
            }
        }
        sets.into_iter().flatten().map(|(name, _, values)| (name, values)).collect()
    }
}

/// The number that stands for 1 in an accessor of weights.
fn whole(layout: Layout) -> f64 {
    match layout.kind {
        5121 => 255.0,
        5123 => 65535.0,
        _ => 1.0,
    }
}

/// Joints with their weights added up, the heaviest `most` of them, with weights that sum to 1; filled up with joint 0 without weight.
pub(super) fn merged(of: impl Iterator<Item = (f64, f64)>, most: usize) -> Vec<(f64, f64)> {
    let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
    of.for_each(|(joint, weight)| *sum.entry(joint as u32).or_default() += weight);
    let mut list: Vec<(f64, f64)> = strongest(sum, most).into_iter().map(|(j, w)| (f64::from(j), w)).collect();
    list.resize(most, (0.0, 0.0));
    list
}

/// Appends numbers with an accessor of the same kind as another one.
fn write_like(document: &mut Document, (name, accessor): (&str, u64), layout: Layout, values: &[f64]) -> usize {
    let stride = (layout.components * layout.size()).next_multiple_of(4);
    document.bin.resize(document.bin.len().next_multiple_of(4), 0);
    let start = document.bin.len();
    for element in values.chunks_exact(layout.components) {
        let end = document.bin.len() + stride;
        element.iter().for_each(|x| document.bin.extend(layout.bytes(*x)));
        document.bin.resize(end, 0);
    }
    let length = document.bin.len() - start;
    let view = json!({"buffer": 0, "byteLength": length, "byteOffset": start, "byteStride": stride, "target": 34962});
    let mut like = document.json["accessors"][accessor as usize].clone();
    like["count"] = json!(values.len() / layout.components);
    like["bufferView"] = json!(push(&mut document.json, "bufferViews", view));
    if let Some(object) = like.as_object_mut() {
        object.remove("byteOffset");
        // Means of positions are within their bounds; those of others are not needed.
        if name != "POSITION" {
            object.remove("min");
            object.remove("max");
        }
    }
    push(&mut document.json, "accessors", like)
}

/// Appends triangles with an accessor of their own.
pub(super) fn write_indices(document: &mut Document, triangles: &[[u32; 3]]) -> usize {
    document.bin.resize(document.bin.len().next_multiple_of(4), 0);
    let start = document.bin.len();
    document.bin.extend(triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
    let length = document.bin.len() - start;
    let view = json!({"buffer": 0, "byteLength": length, "byteOffset": start, "target": 34963});
    let view = push(&mut document.json, "bufferViews", view);
    let accessor = json!({"bufferView": view, "componentType": 5125, "count": 3 * triangles.len(), "type": "SCALAR"});
    push(&mut document.json, "accessors", accessor)
}
