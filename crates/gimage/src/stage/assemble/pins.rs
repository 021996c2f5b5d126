//! Pin conditions: the expressions of `--pin` and `--limit`.

mod parse;

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use crate::base::mesh::{Mesh, Part, Semantic};
use crate::base::words;
use crate::error::Error;
use crate::options::Choice;
use crate::record::{Finding, MAX_EXAMPLES, Severity};
use crate::stage::select::Pattern;

/// The attribute of the source that pins particles, where it is above [`PINS_ABOVE`].
pub const ATTRIBUTE: &str = "_PIN";

/// The value of [`ATTRIBUTE`] above which a particle is pinned.
pub const PINS_ABOVE: f64 = 0.5;

/// The pins of a build beside those of `--pin`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinRule {
    /// None.
    Flags,
    /// Those of the attribute `_PIN` of the source.
    File,
    /// Those too, and where garments rest on the body ([`crate::hold`]).
    Auto,
}

impl Choice for PinRule {
    const ALL: &'static [(&'static str, Self)] = &[("auto", Self::Auto), ("file", Self::File), ("flags", Self::Flags)];
}

/// A condition on a particle. Positions are in metres, after `--unit`.
#[derive(Clone, Debug, PartialEq)]
pub enum Pin {
    /// y above this.
    Above(f64),
    /// y below this.
    Below(f64),
    /// Within this share of the height of a garment below its highest point, each component for itself.
    Top(f64),
    /// Inside the box from the first to the second corner.
    Box([f64; 3], [f64; 3]),
    /// On the `K`-th boundary loop of the garment, the longest being 0.
    Loop(usize),
    /// On any boundary loop of the garment.
    LoopAny,
    /// On the boundary loop of the garment whose mean height is the largest.
    LoopTop,
    /// On the one whose mean height is the smallest.
    LoopBottom,
    /// Within a distance \[m\] of a joint, by name, where the file has it.
    Joint(String, f64),
    /// On a part of the file whose material has a name like this.
    Material(Pattern),
    /// On a part of the file whose node (OBJ: object) has a name like this.
    Node(Pattern),
    /// A custom attribute (by name, first component) above a value.
    Attribute(String, f64),
    /// A component (0..=3 for r, g, b, a) of the first colour above a value.
    Color(usize, f64),
    /// Not this one.
    Not(Box<Pin>),
    /// Both.
    And(Box<Pin>, Box<Pin>),
    /// At least one of both.
    Or(Box<Pin>, Box<Pin>),
}

/// Most joints that a message lists.
const MAX_JOINTS: usize = 40;

const COLORS: [&str; 4] = ["r", "g", "b", "a"];

impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pin::Above(y) => write!(f, "above:{y}"),
            Pin::Below(y) => write!(f, "below:{y}"),
            Pin::Top(share) => write!(f, "top:{share}"),
            Pin::Box(a, b) => write!(f, "box:{},{},{},{},{},{}", a[0], a[1], a[2], b[0], b[1], b[2]),
            Pin::Loop(k) => write!(f, "loop:{k}"),
            Pin::LoopAny => f.write_str("loop:any"),
            Pin::LoopTop => f.write_str("loop:top"),
            Pin::LoopBottom => f.write_str("loop:bottom"),
            Pin::Material(name) => write!(f, "material:{name}"),
            Pin::Node(name) => write!(f, "node:{name}"),
            Pin::Joint(name, distance) => write!(f, "joint:{name}<{distance}"),
            Pin::Not(a) => write!(f, "not ({a})"),
            Pin::And(a, b) => write!(f, "({a}) and ({b})"),
            Pin::Or(a, b) => write!(f, "({a}) or ({b})"),
            Pin::Attribute(name, t) => write!(f, "attr:{name}>{t}"),
            Pin::Color(c, t) => write!(f, "color:{}>{t}", COLORS[*c % 4]),
        }
    }
}

impl FromStr for Pin {
    type Err = Error;

    fn from_str(s: &str) -> Result<Self, Error> {
        parse::parse(s)
    }
}

/// The warning for pins or limits (`option`) that no particle meets, with all there is to choose from: `met` says of each
/// whether a particle does, `bounds` is the box around the garment \[m\], and `loops` counts its boundary loops.
pub(crate) fn unmet(
    option: &'static str,
    values: &[impl fmt::Display],
    met: &[bool],
    bounds: Option<([f64; 3], [f64; 3])>,
    loops: usize,
    mesh: &Mesh,
) -> Option<Finding> {
    let missed: Vec<_> = values.iter().zip(met).filter(|(_, met)| !**met).map(|(value, _)| value).collect();
    if missed.is_empty() {
        return None;
    }
    let (which, s) = if missed.len() == 1 { ("this", "") } else { ("these", "s") };
    let mut message = format!("No particle meets {which} {option}{s}.");
    if let Some((lo, hi)) = bounds {
        let span = |k: usize| words::span(lo[k], hi[k]);
        message += &format!(" The garment spans x {}, y {} and z {} m", span(0), span(1), span(2));
        message += &match loops {
            0 => "; it has no boundary loops".into(),
            1 => "; its only boundary loop is loop:0".into(),
            n => format!("; its boundary loops are loop:0 to loop:{}", n - 1),
        };
        let attributes = attributes(mesh);
        message += &match attributes.is_empty() {
            true => format!("; it has no attributes that a {option} can use."),
            false => format!("; its attributes are {}.", attributes.join(", ")),
        };
        message += &parts(mesh);
        let joints: Vec<&str> = mesh.skeleton.joints.iter().map(|j| j.name.as_str()).take(MAX_JOINTS + 1).collect();
        message += &match joints.len() {
            0 => String::new(),
            n if n > MAX_JOINTS => format!(" Its joints are {}, ...", joints[..MAX_JOINTS].join(", ")),
            _ => format!(" Its joints are {}.", joints.join(", ")),
        };
    }
    Some(Finding {
        severity: Severity::Warning,
        stage: "maps",
        kind: match option {
            "pin" => "nothing-pinned",
            "backstop" => "nothing-held-back",
            "blend" => "nothing-blended",
            _ => "nothing-limited",
        },
        count: missed.len() as u64,
        examples: missed.iter().take(MAX_EXAMPLES).map(ToString::to_string).collect(),
        message,
    })
}

/// The nodes and materials that pins may name, where there are several parts.
fn parts(mesh: &Mesh) -> String {
    let names = |of: &dyn Fn(&Part) -> &str| {
        let used = mesh.triangle_part.iter().map(|&p| p as usize).collect::<BTreeSet<_>>();
        let mut names: Vec<&str> = used.into_iter().filter_map(|p| Some(of(mesh.parts.get(p)?))).collect();
        names.retain(|name| !name.is_empty());
        names.sort_unstable();
        names.dedup();
        let more = if names.len() > MAX_JOINTS { ", ..." } else { "" };
        format!("{}{more}", names[..names.len().min(MAX_JOINTS)].join(", "))
    };
    if mesh.parts.len() < 2 {
        return String::new();
    }
    format!(" Its nodes are {}; its materials are {}.", names(&|p| &p.node), names(&|p| &p.material))
}

/// Attributes that pins may name, with the range of the values: `attr:_PIN (0 to 1)`, `color:r (0.2 to 1)`, ...
fn attributes(mesh: &Mesh) -> Vec<String> {
    let range = |values: &mut dyn Iterator<Item = f32>| {
        let (lo, hi) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
        words::span(lo.into(), hi.into())
    };
    let mut out = Vec::new();
    for channel in mesh.channels.iter().filter(|c| !c.values.is_empty()) {
        let component = |k: usize| range(&mut channel.values.chunks(channel.width).filter_map(|v| v.get(k).copied()));
        match &channel.semantic {
            Semantic::Custom(name) => out.push(format!("attr:{name} ({})", component(0))),
            Semantic::Color(0) => {
                out.extend(COLORS.iter().enumerate().map(|(k, name)| format!("color:{name} ({})", component(k))));
            }
            _ => {}
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Channel;

    #[test]
    fn a_pin_that_selects_nothing_names_bounds_loops_and_attributes() {
        let channel = |semantic, width, values| Channel { semantic, width, values, corners: Vec::new() };
        let mesh = Mesh {
            channels: vec![
                channel(Semantic::Color(0), 4, vec![0.0, 0.1, 0.2, 1.0, 0.5, 0.1, 0.3, 1.0]),
                channel(Semantic::Custom("_PIN".into()), 2, vec![0.0, 7.0, 1.0, 8.0]),
            ],
            ..Mesh::default()
        };
        let pins = [Pin::Above(9.0), Pin::Loop(0), Pin::Loop(5)];
        let bounds = Some(([-0.5, 0.0, -1.0 / 3.0], [0.5, 1.5, 0.25]));
        let finding = unmet("pin", &pins, &[false, true, false], bounds, 2, &mesh).unwrap();
        assert_eq!((finding.count, finding.examples), (2, vec!["above:9".to_owned(), "loop:5".to_owned()]));
        let expected = "No particle meets these pins. The garment spans x -0.5 to 0.5, y 0 to 1.5 and z -0.3333 to 0.25 m; its \
                        boundary loops are loop:0 to loop:1; its attributes are color:r (0 to 0.5), color:g (0.1 to 0.1), \
                        color:b (0.2 to 0.3), color:a (1 to 1), attr:_PIN (0 to 1).";
        assert_eq!(finding.message, expected);
        assert_eq!(unmet("pin", &pins, &[true; 3], bounds, 2, &mesh), None);
        let bare = unmet("pin", &pins[..1], &[false], bounds, 0, &Mesh::default()).unwrap().message;
        assert!(bare.ends_with("no boundary loops; it has no attributes that a pin can use."), "{bare}");
        let limit = unmet("limit", &["loop:1=0.1"], &[false], None, 0, &Mesh::default()).unwrap();
        assert_eq!((limit.kind, limit.message.as_str()), ("nothing-limited", "No particle meets this limit."));
        let kind = |option| unmet(option, &["loop:1=0.1"], &[false], None, 0, &Mesh::default()).unwrap().kind;
        assert_eq!(["backstop", "blend"].map(kind), ["nothing-held-back", "nothing-blended"]);
    }

    #[test]
    fn expressions_read_back_as_written() {
        for s in ["above:1.25", "below:-3", "top:0.06", "box:0,0,0,1,2,3", "loop:2", "attr:_PIN>0.5", "color:g>0.25"] {
            assert_eq!(s.parse::<Pin>().unwrap().to_string(), s);
        }
        for s in [
            "loop:top",
            "loop:bottom",
            "loop:any",
            "material:Cloth_*",
            "node:Mage Cape",
            "joint:upper arm.L<0.25",
            "not (loop:top)",
            "(above:1) and (below:2)",
        ] {
            assert_eq!(s.parse::<Pin>().unwrap().to_string(), s);
        }
    }

    #[test]
    fn not_binds_closer_than_and_which_binds_closer_than_or() {
        let pin = |s: &str| s.parse::<Pin>().unwrap();
        assert_eq!(pin("above:1 or not loop:top and below:2"), pin("(above:1) or ((not (loop:top)) and (below:2))"));
        assert_eq!(pin("(above:1 or loop:top) and below:2").to_string(), "((above:1) or (loop:top)) and (below:2)");
        assert_eq!(pin("not(above:1)and(below:2)").to_string(), "(not (above:1)) and (below:2)");
        let deep = format!("{}above:1{}", "(".repeat(40), ")".repeat(40));
        assert_eq!(pin(&deep), Pin::Above(1.0));
        for s in ["above:1 and", "or above:1", "(above:1", "above:1)", "not", &"(".repeat(9999), &"not ".repeat(9999)] {
            assert!(s.parse::<Pin>().is_err(), "{s}");
        }
    }

    #[test]
    fn bad_expressions_say_why() {
        for s in [
            "",
            "above",
            "above:x",
            "above:nan",
            "top:1.5",
            "top:-0.1",
            "box:1,2,3",
            "loop:-1",
            "attr:_PIN",
            "color:q>1",
            "left:3",
            "joint:chest",
            "material:",
            "node: ",
        ] {
            let e = s.parse::<Pin>().unwrap_err().to_string();
            assert!(e.starts_with("option pin: ") && e.contains(s), "{e}");
        }
    }
}
