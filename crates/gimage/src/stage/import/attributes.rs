//! The attributes of a primitive that survive.

use gimage_bundle::is_binding;
use gltf::json::mesh::{Primitive, Semantic as Name};
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Floats};
use super::findings::Findings;
use crate::base::mesh::Semantic;
use crate::error::Result;
use crate::record::Severity;

/// One attribute, `width` floats a vertex.
#[derive(Clone)]
pub(crate) struct Attribute {
    pub semantic: Semantic,
    pub width: usize,
    pub values: Vec<f32>,
}

/// Reads all attributes but the positions, in the order of their semantics.
pub(crate) fn load(
    accessors: &Accessors,
    primitive: &Primitive,
    vertices: usize,
    element: &str,
    read: impl Fn(&str, usize) -> Result<Floats>,
    findings: &mut Findings,
) -> Result<Vec<Attribute>> {
    let doc = accessors.doc;
    let mut out = Vec::new();
    for (name, accessor) in &primitive.attributes {
        let Checked::Valid(name) = name else {
            let message = "Attributes whose names glTF does not know, without a leading underscore, are not kept.";
            findings.add(Severity::Note, "unknown-attribute", 1, message, || element.into());
            continue;
        };
        let text = name.to_string();
        if is_binding(&text) {
            let message = "Attributes that bind vertices to the pieces of another bundle are left out.";
            findings.add(Severity::Note, "bindings", 1, message, || element.into());
            continue;
        }
        let (semantic, widths) = match name {
            Name::Positions => continue,
            Name::Tangents => {
                let message = "Tangents are not kept; they can be computed from the texture coordinates.";
                findings.add(Severity::Note, "tangents", 1, message, || element.into());
                continue;
            }
            Name::Normals => (Semantic::Normal, 3..=3),
            Name::TexCoords(n) => (Semantic::TexCoord(*n), 2..=2),
            Name::Colors(n) => (Semantic::Color(*n), 3..=4),
            Name::Joints(n) => (Semantic::Joints(*n), 4..=4),
            Name::Weights(n) => (Semantic::Weights(*n), 4..=4),
            Name::Extras(name) => (Semantic::Custom(format!("_{name}")), 1..=16),
        };
        let Floats { width, mut values } = read(&text, accessor.value())?;
        if !widths.contains(&width) {
            return Err(doc.bad(element, format!("{text} has {width} components")));
        }
        if values.len() / width != vertices {
            let problem = format!("{text} has {} values, and there are {vertices} vertices", values.len() / width);
            return Err(doc.bad(element, problem));
        }
        let mut width = width;
        if matches!(semantic, Semantic::Color(_)) && width == 3 {
            values = values.as_chunks::<3>().0.iter().flat_map(|c| [c[0], c[1], c[2], 1.0]).collect();
            width = 4;
        }
        out.push(Attribute { semantic, width, values });
    }
    Ok(out)
}
