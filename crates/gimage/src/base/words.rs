//! Numbers in messages: few digits, and nouns that agree with them.

/// `1 triangle`, `2 triangles`, of the singular and the plural.
pub(crate) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

pub(crate) fn triangles(count: usize) -> String {
    counted(count, "triangle", "triangles")
}

pub(crate) fn vertices(count: usize) -> String {
    counted(count, "vertex", "vertices")
}

pub(crate) fn edges(count: usize) -> String {
    counted(count, "edge", "edges")
}

pub(crate) fn components(count: usize) -> String {
    counted(count, "component", "components")
}

/// A number to four significant digits, the shortest way: `0.3333`, `75`, `1.5e-9`.
pub(crate) fn number(x: f64) -> String {
    rounded(x, 4)
}

/// `-0.3 to 0.3`; an end that is nothing but rounding beside the other is 0.
pub(crate) fn span(lo: f64, hi: f64) -> String {
    let least = 1e-6 * lo.abs().max(hi.abs());
    let [lo, hi] = [lo, hi].map(|x| number(if x.abs() < least { 0.0 } else { x }));
    format!("{lo} to {hi}")
}

/// A point to six digits.
pub(crate) fn point(p: [f64; 3]) -> String {
    let [x, y, z] = p.map(|x| rounded(x, 6));
    format!("({x}, {y}, {z})")
}

fn rounded(x: f64, digits: usize) -> String {
    let rounded: f64 = format!("{x:.*e}", digits - 1).parse().unwrap_or(x);
    let size = rounded.abs();
    if size == 0.0 {
        // Without the sign of -0.
        "0".into()
    } else if (1e-4..1e7).contains(&size) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nouns_agree_and_numbers_are_short() {
        assert_eq!(
            [triangles(1), triangles(2), vertices(1), edges(0)],
            ["1 triangle", "2 triangles", "1 vertex", "0 edges"]
        );
        let cases = [
            (1.0 / 3.0, "0.3333"),
            (75.0, "75"),
            (0.1 + 0.2, "0.3"),
            (-0.0, "0"),
            (123_456.0, "123500"),
            (1.5e-9, "1.5e-9"),
            (1e30, "1e30"),
            (f64::NAN, "NaN"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
        assert_eq!([span(1e-17, 0.8), span(-0.5, 1e-4)], ["0 to 0.8", "-0.5 to 0.0001"]);
        assert_eq!(point([0.1 + 0.2, -1.0 / 3.0, 2e-7]), "(0.3, -0.333333, 2e-7)");
    }
}
