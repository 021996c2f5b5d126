//! Names as USD has them.

use std::collections::BTreeSet;

/// Identifiers for names: letters, digits and `_`, all different. Others become `_`, and a name that is there already gets a number.
pub fn identifiers<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = BTreeSet::new();
    names.map(|name| unique(identifier(name), &mut taken)).collect()
}

/// A name as an identifier.
pub fn identifier(name: &str) -> String {
    let mut out: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if out.is_empty() || out.starts_with(|c: char| c.is_ascii_digit()) {
        out.insert(0, '_');
    }
    out
}

fn unique(name: String, taken: &mut BTreeSet<String>) -> String {
    let mut candidate = name.clone();
    let mut number = 2;
    while !taken.insert(candidate.clone()) {
        candidate = format!("{name}_{number}");
        number += 1;
    }
    candidate
}

/// A text in quotes.
pub fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_different_identifiers() {
        let names = ["shirt", "shirt", "left sleeve", "left.sleeve", "2nd", "", "Ärmel", "shirt_2"];
        let expected = ["shirt", "shirt_2", "left_sleeve", "left_sleeve_2", "_2nd", "_", "_rmel", "shirt_2_2"];
        assert_eq!(identifiers(names.into_iter()), expected);
    }

    #[test]
    fn quotes_and_control_characters_do_not_end_a_text() {
        assert_eq!(quoted("a \"b\"\\\nÄ"), r#""a \"b\"\\ Ä""#);
    }
}
