//! Names components after the parts of the file they came from.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::Component;
use crate::base::mesh::{Mesh, Part};

/// Longest name, in characters, before a number is added.
const LONGEST: usize = 64;

/// Names components, in their order: the part that most of the area came from, made fit for files and unique.
pub(super) fn assign(mesh: &Mesh, components: &mut [Component]) {
    let labels: Vec<String> = mesh.parts.iter().map(label).collect();
    let (mut taken, mut next) = (HashSet::new(), HashMap::new());
    for component in components {
        let mut area: BTreeMap<&str, f64> = BTreeMap::new();
        for &t in &component.triangles {
            let part = mesh.triangle_part.get(t as usize).copied().unwrap_or(0) as usize;
            let label = labels.get(part).map_or("", String::as_str);
            *area.entry(label).or_default() += mesh.triangle_area(t as usize);
        }
        let largest = area.iter().fold(("", -1.0), |best, (&l, &a)| if a > best.1 { (l, a) } else { best }).0;
        let base = if largest.is_empty() { "piece" } else { largest };
        let number = next.entry(base.to_lowercase()).or_insert(1u32);
        component.name = loop {
            let name = if *number == 1 { base.to_owned() } else { format!("{base}_{number}") };
            *number += 1;
            if taken.insert(name.to_lowercase()) {
                break name;
            }
        };
    }
}

/// Node, else mesh, and the material if the file has others there; blanks and characters that paths and shells treat specially become
/// underscores.
fn label(part: &Part) -> String {
    let name = if sanitise(&part.node).is_empty() { &part.mesh } else { &part.node };
    sanitise(&if part.has_siblings { format!("{name}_{}", part.material) } else { name.clone() })
}

fn sanitise(text: &str) -> String {
    let special = |c: char| c.is_whitespace() || c.is_control() || "/\\:*?\"<>|'`$&;".contains(c);
    let mut out = String::new();
    for c in text.chars().map(|c| if special(c) { '_' } else { c }) {
        if c != '_' || !out.ends_with('_') {
            out.push(c);
        }
    }
    let trimmed: String = out.trim_matches(['_', '.']).chars().take(LONGEST).collect();
    trimmed.trim_end_matches(['_', '.']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_fit_for_files() {
        assert_eq!(sanitise(" ../a b//c\n"), "a_b_c");
        assert_eq!(sanitise("Mage_Cape.001"), "Mage_Cape.001");
        assert_eq!(sanitise("__"), "");
        assert_eq!(sanitise("überrock"), "überrock");
    }

    #[test]
    fn a_material_belongs_to_the_name_where_a_node_has_several() {
        let part =
            |has_siblings| Part { node: "Body".into(), material: "Shirt/2".into(), has_siblings, ..Part::default() };
        assert_eq!([part(false), part(true)].map(|p| label(&p)), ["Body", "Body_Shirt_2"]);
    }

    #[test]
    fn a_number_never_meets_a_name_that_has_one() {
        let part = |node: &str| Part { node: node.into(), ..Default::default() };
        let mesh = Mesh {
            positions: vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]],
            triangles: vec![[0, 1, 2]; 5],
            triangle_part: vec![0, 1, 2, 0, 3],
            parts: vec![part("a"), part("A_2"), part("a_2"), part(".")],
            ..Default::default()
        };
        let component = |t| Component {
            triangles: vec![t],
            name: String::new(),
            area: 0.5,
            euler: 1,
            loops: 1,
            orientable: true,
            genus: 0,
            bounds: Default::default(),
            lies_on: None,
        };
        let mut all: Vec<Component> = (0..5).map(component).collect();
        assign(&mesh, &mut all);
        let names: Vec<&str> = all.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["a", "A_2", "a_2_2", "a_3", "piece"]);
    }
}
