//! The text of pin expressions: conditions, combined by `not`, `and`, `or` and parentheses.

use super::{COLORS, Pin};
use crate::error::Error;
use crate::stage::select::Pattern;

/// Deepest nesting of parentheses and `not`.
const MAX_DEPTH: usize = 64;

/// Reads an expression. `not` binds closer than `and`, and `and` closer than `or`.
pub(super) fn parse(text: &str) -> Result<Pin, Error> {
    let mut parser = Parser { text, at: 0, depth: 0 };
    let pin = parser.either()?;
    match parser.rest().trim().is_empty() {
        true => Ok(pin),
        false => Err(parser.bad(&format!("`{}` is left over", parser.rest().trim()))),
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn bad(&self, problem: &str) -> Error {
        Error::Option {
            option: "pin".into(),
            problem: format!("`{}`: {problem}", self.text),
            hint: "use above:Y, below:Y, top:SHARE, box:X0,Y0,Z0,X1,Y1,Z1, loop:K, loop:top, loop:bottom, loop:any, material:NAME, node:NAME, joint:NAME<D, attr:_NAME>T or color:r>T, \
                   combined by not, and, or and parentheses"
                .into(),
        }
    }

    /// Takes a word that blanks or parentheses end.
    fn takes(&mut self, word: &str) -> bool {
        let rest = self.rest().trim_start();
        let found = rest.strip_prefix(word).filter(|after| after.is_empty() || after.starts_with([' ', '\t', '(']));
        if let Some(after) = found {
            self.at = self.text.len() - after.len();
        }
        found.is_some()
    }

    fn either(&mut self) -> Result<Pin, Error> {
        let mut pin = self.both()?;
        while self.takes("or") {
            pin = Pin::Or(Box::new(pin), Box::new(self.both()?));
        }
        Ok(pin)
    }

    fn both(&mut self) -> Result<Pin, Error> {
        let mut pin = self.one()?;
        while self.takes("and") {
            pin = Pin::And(Box::new(pin), Box::new(self.one()?));
        }
        Ok(pin)
    }

    fn one(&mut self) -> Result<Pin, Error> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.bad(&format!("it is nested more than {MAX_DEPTH} deep")));
        }
        let pin = if self.takes("not") {
            Pin::Not(Box::new(self.one()?))
        } else if let Some(after) = self.rest().trim_start().strip_prefix('(') {
            self.at = self.text.len() - after.len();
            let pin = self.either()?;
            let Some(after) = self.rest().trim_start().strip_prefix(')') else {
                return Err(self.bad("`)` is missing"));
            };
            self.at = self.text.len() - after.len();
            pin
        } else {
            self.condition()?
        };
        self.depth -= 1;
        Ok(pin)
    }

    /// A condition: up to the next operator or parenthesis.
    fn condition(&mut self) -> Result<Pin, Error> {
        let rest = self.rest();
        let ends = [" and ", " or ", ")", " and(", " or("].iter().filter_map(|end| rest.find(end));
        let end = ends.min().unwrap_or(rest.len());
        self.at += end;
        self.kind(rest[..end].trim())
    }

    fn kind(&self, s: &str) -> Result<Pin, Error> {
        let bad = |problem: &str| self.bad(problem);
        let number = |t: &str| {
            t.trim().parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| bad(&format!("`{t}` is not a number")))
        };
        let (kind, rest) = s.split_once(':').ok_or_else(|| bad("`:` is missing"))?;
        let compare = |rest: &str, sign: char| -> Result<(String, f64), Error> {
            let (name, t) = rest.rsplit_once(sign).ok_or_else(|| bad(&format!("`{sign}` is missing")))?;
            Ok((name.trim().to_owned(), number(t)?))
        };
        match kind {
            "above" => Ok(Pin::Above(number(rest)?)),
            "below" => Ok(Pin::Below(number(rest)?)),
            "top" => match number(rest)? {
                share if (0.0..=1.0).contains(&share) => Ok(Pin::Top(share)),
                _ => Err(bad("the share is not in 0 to 1")),
            },
            "box" => {
                let n = rest.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
                let &[a, b, c, d, e, f] = n.as_slice() else { return Err(bad("six numbers are required")) };
                Ok(Pin::Box([a.min(d), b.min(e), c.min(f)], [a.max(d), b.max(e), c.max(f)]))
            }
            "loop" => match rest.trim() {
                "top" => Ok(Pin::LoopTop),
                "bottom" => Ok(Pin::LoopBottom),
                "any" => Ok(Pin::LoopAny),
                k => Ok(Pin::Loop(k.parse().map_err(|_| bad("the loop is not a whole number, top, bottom or any"))?)),
            },
            "material" | "node" => {
                let name = rest.trim().parse::<Pattern>().map_err(|_| bad("the name is missing"))?;
                Ok(if kind == "node" { Pin::Node(name) } else { Pin::Material(name) })
            }
            "joint" => {
                let (name, distance) = compare(rest, '<')?;
                Ok(Pin::Joint(name, distance))
            }
            "attr" => {
                let (name, t) = compare(rest, '>')?;
                Ok(Pin::Attribute(name, t))
            }
            "color" => {
                let (name, t) = compare(rest, '>')?;
                let c =
                    COLORS.iter().position(|c| *c == name).ok_or_else(|| bad("the component is not r, g, b or a"))?;
                Ok(Pin::Color(c, t))
            }
            _ => Err(bad("unknown kind")),
        }
    }
}
