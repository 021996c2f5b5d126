//! Divides the triangles of the drawn cloth that are coarser than its particles: a cape of 50 triangles can show no fold, and a
//! body comes through it where its particles go around.
//!
//! Edges longer than a limit are halved, round by round, and triangles are divided by the halves of their edges. Both triangles at
//! an edge have it halved, across primitives too, so that no crack opens. The vertices of the source stay as they are, and come first.

use std::collections::{BTreeMap, HashMap, HashSet};

use serde_json::Value;

use super::Document;
use super::halves::{Halves, is_readable, write_indices};
use super::layout::{Layout, TRIANGLES};
use super::placed::Placed;
use super::trace::{Influence, Trace};
use crate::base::mesh::NONE;
use crate::base::vec3::{add, distance, scale};

/// Rounds, at most: an edge has at most 64 parts.
const ROUNDS: usize = 6;

/// Triangles of the cloth before and after.
#[derive(Debug, PartialEq)]
pub(super) struct Divided {
    pub before: usize,
    pub after: usize,
}

/// Primitives of a mesh with the same vertices.
struct Sheet {
    mesh: usize,
    attributes: Value,
    targets: Value,
    /// Vertices of the source.
    count: usize,
    /// For each vertex that of the imported mesh, or [`NONE`].
    imported: Vec<u32>,
    halves: Halves,
    /// For each primitive its place in the list of placed ones, and its triangles.
    parts: Vec<(usize, Vec<[u32; 3]>)>,
}

/// Halves the edges of cloth that are longer than `longest` \[m\], as long as there are fewer than `most` triangles. Primitives that several nodes place,
/// or whose numbers are stored in a way that is not understood, stay as they are, and so do the edges that cloth shares with them or with what is not
/// cloth. `None` if no edge is too long.
///
/// O(n) in the triangles that come out.
pub(super) fn subdivide(
    document: &mut Document,
    placed: &mut [Placed],
    trace: &mut Trace,
    (longest, most): (f64, usize),
) -> Option<Divided> {
    let mut sheets = sheets(document, placed, trace);
    let held = held(&sheets, placed, trace);
    let of_cloth = |sheet: &Sheet, t: &[u32; 3]| {
        t.iter().all(|v| sheet.imported.get(*v as usize).is_some_and(|i| *i != NONE && trace.is_cloth[*i as usize]))
    };
    let count = |sheets: &[Sheet]| -> usize { sheets.iter().flat_map(|s| &s.parts).map(|p| p.1.len()).sum() };
    let whole = count(&sheets);
    let own = |s: &Sheet| s.parts.iter().flat_map(|p| &p.1).filter(|t| of_cloth(s, t)).count();
    let before: usize = sheets.iter().map(own).sum();
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let first = trace.positions.len() as u32;
    for _ in 0..ROUNDS {
        let so_far = count(&sheets);
        if so_far > most.max(whole) {
            break;
        }
        for sheet in &mut sheets {
            divide(sheet, trace, &mut middles, |trace, [a, b]| {
                let is_held = |v: u32| v < first && held.contains(&place(trace.positions[v as usize]));
                let long = distance(trace.positions[a as usize], trace.positions[b as usize]) > longest;
                long && !(is_held(a) && is_held(b))
            });
        }
        if count(&sheets) == so_far {
            break;
        }
    }
    let after = before + count(&sheets) - whole;
    if after == before {
        return None;
    }
    for sheet in sheets.iter().filter(|s| s.halves.count() > 0) {
        write(document, placed, sheet);
    }
    Some(Divided { before, after })
}

/// The primitives that can be divided.
fn sheets(document: &Document, placed: &[Placed], trace: &Trace) -> Vec<Sheet> {
    let mut uses: HashMap<(usize, usize), usize> = HashMap::new();
    placed.iter().for_each(|p| *uses.entry((p.mesh, p.primitive)).or_default() += 1);
    let users = |mesh: usize| {
        let nodes = document.json["nodes"].as_array().into_iter().flatten();
        nodes.filter(|n| n["mesh"].as_u64() == Some(mesh as u64)).count()
    };
    let mut sheets: BTreeMap<(usize, String), Sheet> = BTreeMap::new();
    for (n, own) in placed.iter().enumerate() {
        let is_cloth = own.imported.iter().any(|v| trace.is_cloth.get(*v as usize).is_some_and(|c| *c));
        if !is_cloth || own.instance.is_some() || uses[&(own.mesh, own.primitive)] > 1 || users(own.mesh) > 1 {
            continue;
        }
        let primitive = &document.json["meshes"][own.mesh]["primitives"][own.primitive];
        let Some(triangles) = triangles(document, primitive) else { continue };
        let (attributes, targets) = (primitive["attributes"].clone(), primitive["targets"].clone());
        let Some(count) = is_readable(document, &attributes, &targets) else { continue };
        let sheet = sheets.entry((own.mesh, format!("{attributes}{targets}"))).or_insert_with(|| Sheet {
            mesh: own.mesh,
            attributes,
            targets,
            count,
            imported: vec![NONE; count],
            halves: Halves::new(count),
            parts: Vec::new(),
        });
        for (&v, &imported) in own.vertices.iter().zip(&own.imported) {
            if let Some(slot) = sheet.imported.get_mut(v as usize) {
                *slot = imported;
            }
        }
        sheet.parts.push((n, triangles));
    }
    sheets.into_values().collect()
}

/// The triangles of a primitive; `None` if it is not a list of triangles, or has vertices that do not exist.
fn triangles(document: &Document, primitive: &Value) -> Option<Vec<[u32; 3]>> {
    if primitive["mode"].as_u64().unwrap_or(TRIANGLES) != TRIANGLES {
        return None;
    }
    let count = document.json["accessors"][primitive["attributes"]["POSITION"].as_u64()? as usize]["count"].as_u64()?;
    let indices: Vec<u32> = match primitive.get("indices") {
        Some(accessor) => {
            let layout = Layout::of(&document.json, &document.bin, accessor.as_u64()?)?;
            layout.numbers(&document.bin).into_iter().map(|x| x as u32).collect()
        }
        None => (0..u32::try_from(count).ok()?).collect(),
    };
    let fits = indices.iter().all(|v| u64::from(*v) < count);
    fits.then(|| indices.as_chunks::<3>().0.to_vec())
}

/// The places of vertices of what is not divided.
fn held(sheets: &[Sheet], placed: &[Placed], trace: &Trace) -> HashSet<[u64; 3]> {
    let divided: HashSet<usize> = sheets.iter().flat_map(|s| &s.parts).map(|p| p.0).collect();
    let others = (0..placed.len()).filter(|n| !divided.contains(n)).flat_map(|n| placed[n].imported.iter().copied());
    let not_cloth = (0..trace.positions.len() as u32).filter(|v| !trace.is_cloth[*v as usize]);
    others.chain(not_cloth).filter_map(|v| trace.positions.get(v as usize)).map(|p| place(*p)).collect()
}

/// The bits of a position; the two zeros are one.
fn place(p: [f64; 3]) -> [u64; 3] {
    p.map(|x| (x + 0.0).to_bits())
}

/// One round for a sheet. `is_long` tells which edges are halved, by their ends in the imported mesh.
fn divide(
    sheet: &mut Sheet,
    trace: &mut Trace,
    middles: &mut HashMap<[u32; 2], u32>,
    is_long: impl Fn(&Trace, [u32; 2]) -> bool,
) {
    let Sheet { imported, halves, parts, .. } = sheet;
    for (_, triangles) in parts {
        let mut next = Vec::with_capacity(triangles.len());
        for t in triangles.iter() {
            let own = t.map(|v| imported[v as usize]);
            let is_flat = own[0] == own[1] || own[1] == own[2] || own[2] == own[0];
            if is_flat || own.iter().any(|v| *v == NONE || !trace.is_cloth[*v as usize]) {
                next.push(*t);
                continue;
            }
            let mut half = [NONE; 3];
            for side in 0..3 {
                let ends = [own[side], own[(side + 1) % 3]];
                if !is_long(trace, ends) {
                    continue;
                }
                let pair = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                let middle = *middles.entry(pair).or_insert_with(|| halve(trace, pair));
                half[side] = halves.of([t[side], t[(side + 1) % 3]]);
                if half[side] as usize == imported.len() {
                    imported.push(middle);
                }
            }
            let from = next.len();
            let flat = |v: u32| trace.positions[imported[v as usize] as usize];
            parts_of(*t, half, |a, b| distance(flat(a), flat(b)), &mut next);
            let own = next[from..].iter().filter(|_| next.len() > from + 1);
            trace.triangles.extend(own.map(|t| t.map(|v| imported[v as usize])));
        }
        *triangles = next;
    }
}

/// A vertex in the middle of an edge of the imported mesh.
fn halve(trace: &mut Trace, [a, b]: [u32; 2]) -> u32 {
    let at = trace.positions.len() as u32;
    let [p, q] = [a, b].map(|v| trace.positions[v as usize]);
    trace.positions.push(scale(add(p, q), 0.5));
    trace.is_cloth.push(true);
    if !trace.lids.is_empty() {
        let [x, y] = [a, b].map(|v| trace.lid(v));
        trace.lids.push(x.min(y));
    }
    let of = |v: u32, n: usize| trace.influences.get(v as usize * trace.sets + n).copied().unwrap_or_default();
    let both: Vec<Influence> = (0..trace.sets).flat_map(|n| [of(a, n), of(b, n)]).collect();
    let pairs = both.iter().flat_map(|(j, w)| j.iter().zip(w)).map(|(j, w)| (f64::from(*j), f64::from(*w)));
    let merged = super::halves::merged(pairs, 4 * trace.sets);
    if !trace.influences.is_empty() {
        let four = |n: usize, of: fn(&(f64, f64)) -> f64| [0, 1, 2, 3].map(|k| of(&merged[4 * n + k]) as f32);
        trace.influences.extend((0..trace.sets).map(|n| (four(n, |x| x.0), four(n, |x| x.1))));
    }
    at
}

/// The parts of a triangle whose sides have vertices in the middle, or [`NONE`].
fn parts_of(t: [u32; 3], half: [u32; 3], far: impl Fn(u32, u32) -> f64, out: &mut Vec<[u32; 3]>) {
    let halved = half.iter().filter(|h| **h != NONE).count();
    // Turned so that the first side is halved, and of two the second one too; of one the others are not.
    let turn = (0..3).find(|k| {
        let [a, b, c] = [0, 1, 2].map(|n| half[(k + n) % 3] != NONE);
        a && (halved == 3 || (halved == 2 && b) || (halved == 1 && !b && !c))
    });
    let Some(turn) = turn else {
        out.push(t);
        return;
    };
    let [a, b, c] = [0, 1, 2].map(|n| t[(turn + n) % 3]);
    let [ab, bc, ca] = [0, 1, 2].map(|n| half[(turn + n) % 3]);
    match halved {
        1 => out.extend([[a, ab, c], [ab, b, c]]),
        2 => {
            out.push([ab, b, bc]);
            // The shorter diagonal of what is left, by which both orders of the corners agree.
            if far(a, bc) <= far(ab, c) {
                out.extend([[a, ab, bc], [a, bc, c]]);
            } else {
                out.extend([[a, ab, c], [ab, bc, c]]);
            }
        }
        _ => out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]),
    }
}

/// Puts the new vertices and triangles of a sheet into the document, and into the lists of what its primitives became.
fn write(document: &mut Document, placed: &mut [Placed], sheet: &Sheet) {
    let (attributes, targets) = sheet.halves.write(document, &sheet.attributes, &sheet.targets);
    for (n, triangles) in &sheet.parts {
        let indices = write_indices(document, triangles);
        let primitive = &mut document.json["meshes"][sheet.mesh]["primitives"][placed[*n].primitive];
        primitive["attributes"] = attributes.clone();
        if !targets.is_null() {
            primitive["targets"] = targets.clone();
        }
        primitive["indices"] = Value::from(indices);
        let more = sheet.count..sheet.imported.len();
        placed[*n].vertices.extend(more.clone().map(|v| v as u32));
        placed[*n].imported.extend(&sheet.imported[more]);
    }
}

#[cfg(test)]
mod tests;
