//! Which particles are pinned: the expressions of `--pin`.

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

/// One condition on a particle. Positions are in metres, after `--unit`.
#[derive(Clone, Debug, PartialEq)]
pub enum Pin {
    /// y above this.
    Above(f64),
    /// y below this.
    Below(f64),
    /// Inside the box from the first to the second corner.
    Box([f64; 3], [f64; 3]),
    /// On the `K`-th boundary loop of the garment, the longest being 0.
    Loop(usize),
    /// A custom attribute (by name, first component) above a value.
    Attribute(String, f64),
    /// A component (0..=3 for r, g, b, a) of the first colour above a value.
    Color(usize, f64),
}

const COLORS: [&str; 4] = ["r", "g", "b", "a"];

impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pin::Above(y) => write!(f, "above:{y}"),
            Pin::Below(y) => write!(f, "below:{y}"),
            Pin::Box(a, b) => write!(f, "box:{},{},{},{},{},{}", a[0], a[1], a[2], b[0], b[1], b[2]),
            Pin::Loop(k) => write!(f, "loop:{k}"),
            Pin::Attribute(name, t) => write!(f, "attr:{name}>{t}"),
            Pin::Color(c, t) => write!(f, "color:{}>{t}", COLORS[*c % 4]),
        }
    }
}

impl FromStr for Pin {
    type Err = Error;

    fn from_str(s: &str) -> Result<Self, Error> {
        let bad = |problem: &str| Error::Option {
            option: "pin".into(),
            problem: format!("`{s}`: {problem}"),
            hint: "use above:Y, below:Y, box:X0,Y0,Z0,X1,Y1,Z1, loop:K, attr:_NAME>T or color:r>T".into(),
        };
        let number = |t: &str| {
            t.trim().parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| bad(&format!("`{t}` is no number")))
        };
        let (kind, rest) = s.split_once(':').ok_or_else(|| bad("there is no `:`"))?;
        let compare = |rest: &str| -> Result<(String, f64), Error> {
            let (name, t) = rest.split_once('>').ok_or_else(|| bad("there is no `>`"))?;
            Ok((name.trim().to_owned(), number(t)?))
        };
        match kind {
            "above" => Ok(Pin::Above(number(rest)?)),
            "below" => Ok(Pin::Below(number(rest)?)),
            "box" => {
                let n = rest.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
                let &[a, b, c, d, e, f] = n.as_slice() else { return Err(bad("six numbers are wanted")) };
                Ok(Pin::Box([a.min(d), b.min(e), c.min(f)], [a.max(d), b.max(e), c.max(f)]))
            }
            "loop" => Ok(Pin::Loop(rest.trim().parse().map_err(|_| bad("the loop is no whole number"))?)),
            "attr" => {
                let (name, t) = compare(rest)?;
                Ok(Pin::Attribute(name, t))
            }
            "color" => {
                let (name, t) = compare(rest)?;
                let c =
                    COLORS.iter().position(|c| *c == name).ok_or_else(|| bad("the component is not r, g, b or a"))?;
                Ok(Pin::Color(c, t))
            }
            _ => Err(bad("unknown kind")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_read_back_as_written() {
        for s in ["above:1.25", "below:-3", "box:0,0,0,1,2,3", "loop:2", "attr:_PIN>0.5", "color:g>0.25"] {
            assert_eq!(s.parse::<Pin>().unwrap().to_string(), s);
        }
    }

    #[test]
    fn bad_expressions_say_why() {
        for s in ["", "above", "above:x", "above:nan", "box:1,2,3", "loop:-1", "attr:_PIN", "color:q>1", "left:3"] {
            let e = s.parse::<Pin>().unwrap_err().to_string();
            assert!(e.starts_with("option pin: ") && e.contains(s), "{e}");
        }
    }
}
