//! Which files make which drawing shader, and what it binds.

use crate::shaders::Slot;

/// Source of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variant {
    /// A cloth, with what it has.
    Cloth { holes: bool, uv: bool },
    /// The meshes of colliders.
    Solids,
    /// Triangles that the host moves.
    Surface,
}

/// Bindings that only drawing has.
pub const VIEW: u32 = 0;
pub const BODIES: u32 = 1;
pub const MESH: u32 = 2;
pub const UV: u32 = 20;
pub const PAINTS: u32 = 21;
pub const TEXELS: u32 = 22;

macro_rules! part {
    ($name:literal) => {
        include_str!(concat!("../../../../shaders/part/", $name, ".wgsl"))
    };
}

impl Variant {
    /// All there are.
    #[cfg(test)]
    pub const ALL: [Variant; 6] = [
        Variant::Solids,
        Variant::Surface,
        Variant::Cloth { holes: false, uv: false },
        Variant::Cloth { holes: false, uv: true },
        Variant::Cloth { holes: true, uv: false },
        Variant::Cloth { holes: true, uv: true },
    ];

    /// The shader's files, in order.
    pub fn files(self) -> Vec<&'static str> {
        let view = part!("view");
        let (light, draw) = (part!("light"), include_str!("../../../../shaders/draw.wgsl"));
        match self {
            Variant::Solids => vec![view, part!("drawn_solid"), light, draw],
            Variant::Surface => vec![view, light, include_str!("../../../../shaders/draw_surface.wgsl")],
            Variant::Cloth { holes, uv } => {
                let holes = if holes { part!("drawn_holes") } else { part!("drawn_whole") };
                let uv = if uv { part!("drawn_uv") } else { part!("drawn_plain") };
                vec![view, part!("grid"), part!("grids"), holes, uv, part!("drawn_cloth"), light, draw]
            }
        }
    }

    /// The storage buffers that it reads, by binding; those of paints in the fragment stage.
    pub fn storage(self) -> Vec<u32> {
        match self {
            Variant::Solids => vec![BODIES, MESH],
            Variant::Surface => vec![MESH, PAINTS, TEXELS],
            Variant::Cloth { holes, uv } => {
                let slots = [Slot::Grids, Slot::Now, Slot::Before, Slot::Normals].map(|s| s as u32);
                let more = [(holes, Slot::Holes as u32), (uv, UV)];
                slots.into_iter().chain(more.into_iter().filter_map(|(on, binding)| on.then_some(binding))).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::mem::offset_of;

    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use naga::{AddressSpace, TypeInner};

    use super::*;
    use crate::draw::rows::{BodyRow, PaintRow, ViewRow};
    use crate::layout::GridRow;

    macro_rules! rust {
        ($t:ty: $($field:ident),*) => {
            (vec![$((stringify!($field), offset_of!($t, $field) as u32)),*], size_of::<$t>() as u32)
        };
    }

    #[test]
    fn every_variant_is_valid_binds_what_it_says_and_lies_as_in_rust() {
        let view = rust!(ViewRow: clip, eye, fraction, middle, tiles, background, shade, light, jump, front, back);
        let body = rust!(BodyRow: rotation, center, fade, color);
        let paint = rust!(PaintRow: color, alpha, cutoff, wrap, first, levels, pad_a, pad_b, pad_c);
        let grid = rust!(GridRow: first, width, height, soft, rest);
        for variant in Variant::ALL {
            let text = variant.files().concat();
            let module = naga::front::wgsl::parse_str(&text);
            let module = module.unwrap_or_else(|e| panic!("{variant:?}: {}", e.emit_to_string(&text)));
            let valid = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
            valid.unwrap_or_else(|e| panic!("{variant:?}: {}", e.emit_to_string(&text)));
            let bound =
                module.global_variables.iter().filter_map(|(_, v)| Some((v.binding.as_ref()?.binding, v.space)));
            let (uniform, storage): (Vec<_>, Vec<_>) = bound.partition(|(_, space)| *space == AddressSpace::Uniform);
            assert_eq!(uniform.iter().map(|b| b.0).collect::<Vec<_>>(), [VIEW]);
            let storage: BTreeSet<_> = storage.iter().map(|b| b.0).collect();
            assert_eq!(storage, variant.storage().into_iter().collect(), "{variant:?}");
            assert!(storage.len() <= 8, "{variant:?} binds more storage buffers than WebGPU promises");
            for (_, ty) in module.types.iter() {
                let TypeInner::Struct { members, span } = &ty.inner else { continue };
                let rust = match ty.name.as_deref() {
                    Some("View") => &view,
                    Some("Body") => &body,
                    Some("Grid") => &grid,
                    Some("Paint") => &paint,
                    Some("Corner" | "Point" | "Drawn" | "Shaded") => continue,
                    other => panic!("{other:?} has no counterpart"),
                };
                let wgsl: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset)).collect();
                assert_eq!((&wgsl, span), (&rust.0, &rust.1), "{:?}", ty.name);
            }
        }
    }
}
