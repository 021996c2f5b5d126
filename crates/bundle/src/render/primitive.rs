//! The triangles of the file.

use serde_json::Value;

use super::matrix::Matrix;
use super::nodes::Placed;
use super::{BLEND, COORD, JOINTS, OFFSET, RenderFile, WEIGHTS, damaged};
use crate::error::Result;

/// A primitive of a mesh as a node places it. Lists have an entry per vertex; those of attributes that are absent are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderPrimitive {
    /// The node; none in a file without nodes.
    pub node: Option<usize>,
    /// The mesh.
    pub mesh: usize,
    /// Its number in the mesh.
    pub index: usize,
    /// The name of the node, else of the mesh, else empty.
    pub name: String,
    /// The transform of the node to the world of the file, column by column.
    pub world: Matrix,
    /// Positions in the space of the mesh.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals in the space of the mesh.
    pub normals: Vec<[f32; 3]>,
    /// Unit tangents in the space of the mesh, and the sign of the bitangent.
    pub tangents: Vec<[f32; 4]>,
    /// Texture coordinates of the base colour.
    pub uv: Vec<[f32; 2]>,
    /// Linear colours that multiply the base colour (`COLOR_0`); alpha is 1 where the file has three components.
    pub colors: Vec<[f32; 4]>,
    /// Triangles, three vertices each; every index is below the number of vertices.
    pub indices: Vec<u32>,
    /// The piece, or -1 for a vertex that is not bound, and u and v. Empty if no vertex is bound.
    pub coords: Vec<[f32; 3]>,
    /// Offsets \[m\] in the frame of the surface.
    pub offsets: Vec<[f32; 3]>,
    /// Four joints of the skeleton of the bundle and their weights, `sets` per vertex; empty where vertices do not blend to the skin.
    pub influences: Vec<([u32; 4], [f32; 4])>,
    /// Sets of four joints per vertex.
    pub sets: usize,
    /// Shares, 0 to 1, that multiply the blend of the vertices' points of the surface.
    pub blends: Vec<f32>,
    /// The material, for [`RenderFile::material`].
    pub material: Option<usize>,
}

/// Those of the scene.
pub(super) fn all(file: &RenderFile) -> Result<Vec<RenderPrimitive>> {
    let mut out = Vec::new();
    for placed in file.placed()? {
        let mesh = file.list("meshes").get(placed.mesh);
        let mesh = mesh.ok_or_else(|| damaged(format!("mesh {}", placed.mesh), "it does not exist"))?;
        for (index, primitive) in mesh["primitives"].as_array().into_iter().flatten().enumerate() {
            out.extend(load(file, &placed, mesh, index, primitive)?);
        }
    }
    Ok(out)
}

/// One of them; `None` if it has no triangles.
fn load(
    file: &RenderFile,
    placed: &Placed,
    mesh: &Value,
    index: usize,
    primitive: &Value,
) -> Result<Option<RenderPrimitive>> {
    let mode = primitive["mode"].as_u64().unwrap_or(4);
    let accessor = |name: &str| primitive["attributes"][name].as_u64().map(|a| a as usize);
    let Some(position) = accessor("POSITION").filter(|_| (4..=6).contains(&mode)) else { return Ok(None) };
    let element = format!("mesh {}, primitive {index}", placed.mesh);
    let positions: Vec<[f32; 3]> = vectors(file, &element, "POSITION", Some(position), None)?;
    let count = positions.len();
    let order = match primitive["indices"].as_u64() {
        Some(indices) => file.indices(indices as usize)?,
        None => (0..count as u32).collect(),
    };
    if let Some(v) = order.iter().find(|&&v| v as usize >= count) {
        return Err(damaged(element, format!("it uses vertex {v} of {count}")));
    }
    let material = primitive["material"].as_u64().map(|m| m as usize);
    let set = format!("TEXCOORD_{}", file.material(material).base_set);
    let named = |value: &Value| value["name"].as_str().map(String::from);
    let name = placed.node.and_then(|n| named(&file.list("nodes")[n])).or_else(|| named(mesh));
    let read3 = |name: &str| vectors::<3>(file, &element, name, accessor(name), Some(count));
    let (coords, offsets) = (read3(COORD)?, read3(OFFSET)?);
    if coords.len() != offsets.len() {
        return Err(damaged(element, format!("it has only one of {COORD} and {OFFSET}")));
    }
    let sets = (0..)
        .map_while(|n| Some((accessor(&numbered(JOINTS, n))?, accessor(&numbered(WEIGHTS, n))?)))
        .map(|(joints, weights)| {
            let joints = vectors::<4>(file, &element, JOINTS, Some(joints), Some(count))?;
            Ok((joints, vectors::<4>(file, &element, WEIGHTS, Some(weights), Some(count))?))
        })
        .collect::<Result<Vec<_>>>()?;
    let whole = |joints: [f32; 4]| joints.map(|j| if j >= 0.0 && j.fract() == 0.0 { j as u32 } else { u32::MAX });
    let influence = |v: usize| sets.iter().map(move |(joints, weights)| (whole(joints[v]), weights[v]));
    Ok(Some(RenderPrimitive {
        influences: (0..count).flat_map(influence).collect(),
        sets: sets.len(),
        blends: vectors::<1>(file, &element, BLEND, accessor(BLEND), Some(count))?.into_flattened(),
        node: placed.node,
        mesh: placed.mesh,
        index,
        name: name.unwrap_or_default(),
        world: placed.world,
        normals: read3("NORMAL")?,
        tangents: vectors(file, &element, "TANGENT", accessor("TANGENT"), Some(count))?,
        uv: vectors(file, &element, &set, accessor(&set), Some(count))?,
        colors: colors(file, &element, accessor("COLOR_0"), count)?,
        indices: triangles(mode, &order),
        coords,
        offsets,
        material,
        positions,
    }))
}

/// Whether an attribute is one that binds vertices to the pieces of a bundle.
pub fn is_binding(name: &str) -> bool {
    [COORD, OFFSET, JOINTS, WEIGHTS, BLEND]
        .iter()
        .any(|own| name.strip_prefix(own).is_some_and(|set| set.bytes().all(|b| b.is_ascii_digit())))
}

/// The name of the attribute [`JOINTS`] or [`WEIGHTS`] of a set of four joints.
pub fn numbered(name: &str, set: usize) -> String {
    if set == 0 { name.into() } else { format!("{name}{set}") }
}

/// An attribute, empty if it is absent; `count` is the number of vertices, if it is known.
fn vectors<const N: usize>(
    file: &RenderFile,
    element: &str,
    name: &str,
    accessor: Option<usize>,
    count: Option<usize>,
) -> Result<Vec<[f32; N]>> {
    let Some(accessor) = accessor else { return Ok(Vec::new()) };
    let floats = file.floats(accessor)?;
    if floats.width != N {
        return Err(damaged(element, format!("{name} has {} components, not {N}", floats.width)));
    }
    let values: Vec<[f32; N]> = floats.values.as_chunks::<N>().0.to_vec();
    match count {
        Some(n) if n != values.len() => {
            Err(damaged(element, format!("{name} has {} elements for {n} vertices", values.len())))
        }
        _ => Ok(values),
    }
}

/// Colours of vertices, with three or four components.
fn colors(file: &RenderFile, element: &str, accessor: Option<usize>, count: usize) -> Result<Vec<[f32; 4]>> {
    let Some(index) = accessor else { return Ok(Vec::new()) };
    if file.floats(index)?.width != 3 {
        return vectors(file, element, "COLOR_0", accessor, Some(count));
    }
    let three = vectors::<3>(file, element, "COLOR_0", accessor, Some(count))?;
    Ok(three.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
}

/// A list of triangles from a list, a strip or a fan.
fn triangles(mode: u64, order: &[u32]) -> Vec<u32> {
    let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    let strip = |(k, w): (usize, &[u32])| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
    match mode {
        5 => order.windows(3).enumerate().map(strip).filter(whole).flatten().collect(),
        6 => {
            let (hub, rim) = order.split_first().map_or((0, &[][..]), |(&hub, rim)| (hub, rim));
            rim.windows(2).map(|w| [w[0], w[1], hub]).filter(whole).flatten().collect()
        }
        _ => order.as_chunks::<3>().0.as_flattened().to_vec(),
    }
}
