//! One option with everything that is known of it: what checks, manifest, help and pages are made from.

use std::fmt;

use serde_json::Value;

use crate::error::{Error, Result};

/// The values that an option takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Every value of its type.
    Any,
    /// Finite numbers.
    Finite,
    /// Finite numbers above this one.
    Above(f64),
    /// Numbers from the first to the second, both included.
    Between(f64, f64),
    /// Two sides from the first to the second, whose product is at most the third.
    Sides(u32, u32, u32),
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Range::Any => Ok(()),
            Range::Finite => f.write_str("finite"),
            Range::Above(low) => write!(f, "above {low}"),
            Range::Between(low, high) => write!(f, "{low} to {high}"),
            Range::Sides(low, high, most) => write!(f, "sides of {low} to {high}, at most {most} texels"),
        }
    }
}

impl Range {
    /// The permitted values in words, as part of a sentence: `a number above 0`.
    pub fn words(&self) -> String {
        match self {
            Range::Any => "another value".into(),
            Range::Finite => "a finite number".into(),
            Range::Above(_) => format!("a number {self}"),
            Range::Between(..) => format!("a number from {self}"),
            Range::Sides(..) => self.to_string(),
        }
    }

    /// Whether numbers are in the range.
    pub fn holds(&self, numbers: &[f64]) -> bool {
        match *self {
            Range::Any => true,
            Range::Finite => numbers.iter().all(|x| x.is_finite()),
            Range::Above(low) => numbers.iter().all(|x| x.is_finite() && *x > low),
            Range::Between(low, high) => numbers.iter().all(|x| (low..=high).contains(x)),
            Range::Sides(low, high, most) => {
                let side = |x: &f64| (f64::from(low)..=f64::from(high)).contains(x);
                numbers.iter().all(side) && numbers.iter().product::<f64>() <= f64::from(most)
            }
        }
    }
}

/// An option of a build and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The stage that it belongs to.
    pub stage: &'static str,
    /// The name on the command line, without dashes; with underscores it is the name in the manifest.
    pub name: &'static str,
    /// The unit of its numbers, empty for none.
    pub unit: &'static str,
    /// The values that it takes.
    pub range: Range,
    /// The words that it takes, if it takes words.
    pub choices: Vec<&'static str>,
    /// The effect, in sentences.
    pub help: String,
    /// The value as JSON, `None` for an option that was not given.
    pub value: Option<Value>,
    /// The numbers of the value, for the check: JSON has no NaN.
    pub numbers: Vec<f64>,
    /// Whether it goes into the manifest, as all options do that change a bundle.
    pub recorded: bool,
}

impl Setting {
    /// The value in words; empty if there is none.
    fn words(&self) -> String {
        match &self.value {
            Some(Value::String(text)) => text.clone(),
            // A flag: `no-x` is on if `x` is false.
            Some(Value::Bool(x)) => String::from(if *x == self.name.starts_with("no-") { "off" } else { "on" }),
            Some(Value::Number(_)) => self.numbers.iter().map(f64::to_string).collect(),
            _ => String::new(),
        }
    }

    /// The help of the command line: the effect, then default and range in brackets. Words to choose from are left to the
    /// parser, which knows them.
    pub(super) fn help(&self) -> String {
        let mut facts = Vec::new();
        match &self.value {
            Some(Value::Bool(_)) => {}
            _ if self.words().is_empty() => {}
            _ => facts.push(format!("default: {}", self.words())),
        }
        if !matches!(self.range, Range::Any | Range::Finite) {
            facts.push(self.range.to_string());
        }
        // Help texts end without a period, as the parser ends those of its comments.
        let effect = self.help.trim_end_matches('.');
        if facts.is_empty() { effect.into() } else { format!("{effect} [{}]", facts.join("; ")) }
    }

    /// The row of the table in docs/building.md.
    #[cfg(test)]
    pub(super) fn row(&self) -> String {
        let Setting { name, stage, unit, help, .. } = self;
        let range = if self.choices.is_empty() { self.range.to_string() } else { self.choices.join(", ") };
        let cells = [&format!("`--{name}`"), *stage, help, *unit, &self.words(), &range];
        cells.iter().fold("|".to_owned(), |row, cell| row + if cell.is_empty() { "" } else { " " } + cell + " |")
    }
}

/// Checks every setting against its range; the error names the first one that is outside.
pub(crate) fn check(settings: &[Setting]) -> Result<()> {
    let Some(bad) = settings.iter().find(|setting| !setting.range.holds(&setting.numbers)) else { return Ok(()) };
    let numbers: Vec<String> = bad.numbers.iter().map(f64::to_string).collect();
    let unit = if bad.unit.is_empty() || bad.unit == "share" { String::new() } else { format!(", in {}", bad.unit) };
    Err(Error::Option {
        option: bad.name.into(),
        problem: format!("{} is out of range", numbers.join(" x ")),
        hint: format!("give {}{unit}", bad.range.words()),
    })
}
