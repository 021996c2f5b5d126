//! One primitive of a glTF mesh: its triangles and attributes, before it is placed.

use gltf::json::mesh::{Mode, Primitive, Semantic as Name};
use gltf::json::validation::Checked;
use serde_json::Value;

use super::accessor::{Accessors, Floats};
use super::attributes::{self, Attribute};
use super::findings::Findings;
use super::{draco, grid, malformed};
use crate::error::Result;
use crate::record::Severity;

/// A primitive as its file has it; every index is below the number of vertices.
pub(crate) struct Raw {
    /// Its name in messages.
    pub element: String,
    /// Three floats a vertex, in the mesh's space.
    pub positions: Vec<f32>,
    /// Width of the cells of the grid to which they are rounded; 0 if there is none.
    pub grid: f64,
    pub triangles: Vec<[u32; 3]>,
    pub attributes: Vec<Attribute>,
}

/// Where the numbers of a primitive come from.
struct Streams<'a, 'b> {
    accessors: &'a Accessors<'b>,
    element: &'a str,
    packed: Option<(draco::Decoded, &'a serde_json::Map<String, Value>)>,
}

impl Streams<'_, '_> {
    fn attribute(&self, name: &str, accessor: usize) -> Result<Floats> {
        let doc = self.accessors.doc;
        let Some((decoded, id)) = self.packed.as_ref().and_then(|(d, ids)| Some((d, ids.get(name)?))) else {
            return self.accessors.floats(accessor);
        };
        let values = id.as_u64().and_then(|id| decoded.attribute(u32::try_from(id).ok()?));
        let Some((width, mut values)) = values else {
            let problem = format!("its Draco stream has no attribute {id} for {name}");
            return Err(doc.bad(self.element, problem));
        };
        // The decoder gives integers as they are; what they mean stands in the accessor.
        let top = self.accessors.normalizer(accessor)?;
        if top > 1.0 {
            values.iter_mut().for_each(|v| *v = (*v / top).max(-1.0));
        }
        Ok(Floats { width, values })
    }
}

/// Reads a primitive; `None` if it has no triangles.
pub(crate) fn load(
    accessors: &Accessors,
    mesh: usize,
    index: usize,
    max_vertices: usize,
    max_triangles: usize,
    findings: &mut Findings,
) -> Result<Option<Raw>> {
    let doc = accessors.doc;
    let primitive = &doc.root.meshes[mesh].primitives[index];
    let element = format!("mesh {mesh} `{}`, primitive {index}", doc.mesh_name(mesh));
    let Checked::Valid(mode) = primitive.mode else {
        return Err(doc.bad(element, "glTF does not define its mode"));
    };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        let message = "Points and lines have no surface and were left out.";
        findings.add(Severity::Repair, "points-and-lines", 1, message, || element);
        return Ok(None);
    }
    let Some(position) = primitive.attributes.get(&Checked::Valid(Name::Positions)).map(|a| a.value()) else {
        let message = "Primitives without positions were left out.";
        findings.add(Severity::Repair, "no-positions", 1, message, || element);
        return Ok(None);
    };
    let packed = unpack(accessors, primitive, &element, max_vertices, max_triangles)?;
    let streams = Streams { accessors, element: &element, packed };
    let positions = streams.attribute("POSITION", position)?;
    if positions.width != 3 {
        return Err(doc.bad(element, format!("POSITION has {} components, not 3", positions.width)));
    }
    let vertices = positions.values.len() / 3;
    let order = match (&streams.packed, primitive.indices) {
        (Some((decoded, _)), _) => decoded.indices(),
        (None, Some(i)) => accessors.vertex_indices(i.value())?,
        (None, None) => (0..vertices as u32).collect(),
    };
    // A Draco stream always holds plain triangles.
    let mode = if streams.packed.is_some() { Mode::Triangles } else { mode };
    if mode == Mode::Triangles && order.len() % 3 != 0 {
        let message = "An index list ended inside a triangle; the rest was left out.";
        findings.add(Severity::Repair, "incomplete-triangle", 1, message, || element.clone());
    }
    let triangles = triangles(mode, &order);
    let wrong = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= vertices);
    if let Some(t) = triangles.iter().position(wrong) {
        let v = triangles[t].iter().max().copied().unwrap_or(0);
        let problem = format!("triangle {t} uses vertex {v}, and there are {vertices}");
        return Err(doc.bad(element, problem));
    }
    if triangles.is_empty() {
        let message = "Primitives without a whole triangle were left out.";
        findings.add(Severity::Repair, "no-triangles", 1, message, || element);
        return Ok(None);
    }
    let morphs = primitive.targets.as_ref().map_or(0, Vec::len);
    let message = "Morph targets are not kept; the mesh is read without them.";
    findings.add(Severity::Note, "morph-targets", morphs, message, || element.clone());
    let read = |name: &str, accessor: usize| streams.attribute(name, accessor);
    let attributes = attributes::load(accessors, primitive, vertices, &element, read, findings)?;
    let grid = match accessors.integer_step(position)? {
        Some(step) if streams.packed.is_none() => step,
        _ => grid::of(&positions.values),
    };
    Ok(Some(Raw { element, positions: positions.values, grid, triangles, attributes }))
}

fn unpack<'a>(
    accessors: &Accessors,
    primitive: &'a Primitive,
    element: &str,
    max_vertices: usize,
    max_triangles: usize,
) -> Result<Option<(draco::Decoded, &'a serde_json::Map<String, Value>)>> {
    let extensions = primitive.extensions.as_ref();
    let Some(header) = extensions.and_then(|e| e.others.get("KHR_draco_mesh_compression")) else { return Ok(None) };
    let bad = |problem: String| {
        let hint = "compress it again, or decompress it with `npx @gltf-transform/cli copy in.glb out.glb`";
        malformed(accessors.doc.path, element, format!("Draco compression: {problem}"), hint)
    };
    let ids = header["attributes"].as_object().ok_or_else(|| bad("it lists no attributes".into()))?;
    let view = header["bufferView"].as_u64().ok_or_else(|| bad("it names no buffer view".into()))?;
    let data = accessors.buffers.view(view as usize)?.bytes;
    let decoded = draco::decode(data, max_vertices, max_triangles).map_err(bad)?;
    accessors.buffers.spend(decoded.vertex_count() as u64 * 16, element)?;
    Ok(Some((decoded, ids)))
}

/// The triangles of an index list. Those of strips and fans that only stitch (two equal indices) are dropped.
fn triangles(mode: Mode, order: &[u32]) -> Vec<[u32; 3]> {
    let stitch = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    match mode {
        Mode::TriangleStrip => {
            let turn = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            order.windows(3).enumerate().map(turn).filter(stitch).collect()
        }
        Mode::TriangleFan => match order.split_first() {
            Some((&hub, rim)) => rim.windows(2).map(|w| [w[0], w[1], hub]).filter(stitch).collect(),
            None => Vec::new(),
        },
        _ => order.as_chunks::<3>().0.to_vec(),
    }
}
