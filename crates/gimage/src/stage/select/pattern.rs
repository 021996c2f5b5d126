//! Names with `*` and numbers of components, as the flags --cloth, --body and --rigid take them.

use std::fmt;
use std::str::FromStr;

use crate::base::mesh::Part;
use crate::error::{Error, Result};

/// Before the number of a component.
const COMPONENT: &str = "component:";

/// A name of a node, mesh or material, or of both as `NODE/MATERIAL`, in which `*` stands for any text, or `component:K`, the connected component of
/// that number. Letter case is ignored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern(String);

impl Pattern {
    /// Whether a name matches. O(length of the pattern x length of the name).
    pub fn matches(&self, name: &str) -> bool {
        let (pattern, name): (Vec<char>, Vec<char>) = (lower(&self.0), lower(name));
        let (mut p, mut n) = (0, 0);
        // The last `*`, and the first character of the name that it does not take.
        let mut star: Option<(usize, usize)> = None;
        while n < name.len() {
            match pattern.get(p) {
                Some('*') => {
                    star = Some((p, n));
                    p += 1;
                }
                Some(c) if *c == name[n] => (p, n) = (p + 1, n + 1),
                _ => match star {
                    Some((at, taken)) => {
                        star = Some((at, taken + 1));
                        (p, n) = (at + 1, taken + 1);
                    }
                    None => return false,
                },
            }
        }
        pattern[p..].iter().all(|c| *c == '*')
    }

    /// The number of the component that it chooses; `None` if it chooses by name.
    pub fn component(&self) -> Option<u32> {
        let number = self.0.get(COMPONENT.len()..)?;
        self.0.get(..COMPONENT.len())?.eq_ignore_ascii_case(COMPONENT).then(|| number.parse().ok())?
    }

    /// Whether the node, the mesh or the material of a part matches, or its `NODE/MATERIAL`, or the part is the component of this number.
    pub fn matches_part(&self, part: &Part) -> bool {
        if let Some(number) = self.component() {
            return part.component == Some(number);
        }
        let both = || self.0.contains('/') && self.matches(&format!("{}/{}", part.node, part.material));
        [&part.node, &part.mesh, &part.material].iter().any(|name| self.matches(name)) || both()
    }
}

fn lower(text: &str) -> Vec<char> {
    text.chars().flat_map(char::to_lowercase).collect()
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for Pattern {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text.is_empty() {
            return Err(Error::Option {
                option: "cloth, body or rigid".into(),
                problem: "a name is empty".into(),
                hint:
                    "give a name of a node, mesh or material, a pattern such as Mage_*, or a number such as component:3"
                        .into(),
            });
        }
        Ok(Self(text.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_text() {
        let matches = |pattern: &str, name: &str| pattern.parse::<Pattern>().unwrap().matches(name);
        for (pattern, name) in [
            ("Mage_Cape", "Mage_Cape"),
            ("mage_cape", "Mage_Cape"),
            ("*", ""),
            ("*", "anything"),
            ("*Cape", "Mage_Cape"),
            ("Mage*", "Mage_Cape"),
            ("*ag*ap*", "Mage_Cape"),
            ("a*b*c", "aXbXbXc"),
            ("**", "x"),
            ("ÜBER*", "überrock"),
        ] {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in
            [("Cape", "Mage_Cape"), ("*Cap", "Mage_Cape"), ("Mage?", "Mages"), ("a*b", "abc"), ("x*", "")]
        {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
        let number = |text: &str| text.parse::<Pattern>().unwrap().component();
        assert_eq!([number("component:12"), number("Component:0")], [Some(12), Some(0)]);
        assert_eq!(["component", "component:", "component:x", "component:-1", "ü:3"].map(number), [None; 5]);
        let part = Part { node: "Body".into(), material: "Shirt".into(), ..Part::default() };
        let chooses = |text: &str| text.parse::<Pattern>().unwrap().matches_part(&part);
        assert!(
            chooses("body/shirt")
                && chooses("Body/*")
                && chooses("*/Shirt")
                && !chooses("Shirt/Body")
                && !chooses("B*t")
        );
        assert!("".parse::<Pattern>().is_err());
        assert_eq!("Mage_*".parse::<Pattern>().unwrap().to_string(), "Mage_*");
    }
}
